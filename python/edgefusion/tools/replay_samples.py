# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A recording of any kind as what a robot would have told on its bus. Commands are never among it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Callable, Dict, Iterator, NamedTuple, Optional, Tuple

from edgefusion.bus.topics import CAMERA_INFO, IMAGE, SCAN, TF_STATIC, TOPICS, Direction, Topic
from edgefusion.errors import RefusedError
from edgefusion.messages import Message, ros_name
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.from_camera_info import from_camera_info
from edgefusion.messages.from_image import from_image
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.sensor_msgs import CompressedImage, Image
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_raw_image import to_raw_image
from edgefusion.messages.transform import mounting
from edgefusion.recording.bag import Bag, BagMessage, BagTopic, naming, table
from edgefusion.recording.bag_recording import UTC
from edgefusion.recording.recording import Recording
from edgefusion.recording.topic_choice import (
    NotThereError,
    TopicNames,
    camera_info_topic,
    image_topic,
    scan_topic,
)
from edgefusion.types import Frame, Scan

if TYPE_CHECKING:
    from edgefusion.perception.calibration import Calibration

QUALITY = 95
"""Of JPEGs that are made of what was recorded otherwise: so that who looks at them finds what the robot found."""


class Sample(NamedTuple):
    """at_ns: when it is to be put, on the recording's own time. stamp_ns: what it is of, on its sender's clock."""

    topic: Topic
    payload: bytes
    stamp_ns: int
    at_ns: int


def plan(bag: Bag, names: TopicNames, calibrated: bool = False) -> Dict[str, Topic]:
    """Which topics of a bag go to which of the bus: those of the same name and type, the laser's, and the camera's.

    calibrated: the camera's calibration is known otherwise, that in the bag is left out.
    Raises RefusedError where there is none, or a name is not found.
    """
    found = {topic.name: TOPICS[topic.name.strip("/")] for topic in bag.topics if _is_told(topic)}
    _take(found, SCAN, lambda: scan_topic(bag, names))
    image = _take(found, IMAGE, lambda: image_topic(bag, names))
    if calibrated:
        found = {name: topic for name, topic in found.items() if topic is not CAMERA_INFO}
    elif image is not None:
        _take(found, CAMERA_INFO, lambda: camera_info_topic(bag, names, image))
    if not found:
        raise RefusedError(f"{bag.path}: expected laser scans, camera images or topics of the bus, found {table(bag)}")
    return found


def bag_samples(bag: Bag, planned: Dict[str, Topic]) -> Iterator[Sample]:
    """The messages of these topics, as they were recorded; only raw images become JPEG.

    Raises RefusedError for a message that is none.
    """
    for message in bag.read(set(planned)):
        topic = planned[message.topic]
        if message.type_name == ros_name(Image):
            image, stamp_ns = _as_jpeg(bag, message)
            yield Sample(topic, encode(image), stamp_ns, message.log_ns)
        else:
            yield Sample(topic, message.data, _stamp_ns(bag, message, topic), message.log_ns)


def drive_samples(recording: Recording, calibration: Optional[Calibration]) -> Iterator[Sample]:
    """Scans and frames of a folder or log and, where the calibration is known, what the bus tells of it.

    Where they begin before 1970, as a recording from 0 on does once latencies are taken off, they begin then.
    """
    latencies = (0, 0) if calibration is None else (calibration.laser_latency_ns, calibration.camera_latency_ns)
    stamper: Optional[Stamper] = None
    for message in recording.messages(*latencies):
        at_ns = message.stamp_ns
        if stamper is None:
            stamper = Stamper(max(0, -at_ns))
            if calibration is not None:
                transforms = mounting(calibration.T_base_laser, calibration.T_camera_laser)
                yield _made(TF_STATIC, from_transforms(at_ns, transforms, stamper), at_ns, stamper)
        if isinstance(message, Scan):
            yield _made(SCAN, from_scan(message, stamper), at_ns, stamper)
        else:
            yield from _frame_samples(message, calibration, stamper)


def _frame_samples(frame: Frame, calibration: Optional[Calibration], stamper: Stamper) -> Iterator[Sample]:
    at_ns = frame.stamp_ns
    if calibration is not None:
        camera = Intrinsics(calibration.image_size, calibration.K, calibration.distortion)
        yield _made(CAMERA_INFO, from_camera_info(at_ns, camera, stamper), at_ns, stamper)
    yield _made(IMAGE, from_image(frame, stamper, QUALITY), at_ns, stamper)


def _as_jpeg(bag: Bag, message: BagMessage) -> Tuple[CompressedImage, int]:
    """A raw image with the header that it has, and its stamp [ns]."""
    with naming(bag, message):
        raw = decode(Image, message.data)
        frame = to_raw_image(raw, UTC)
        return replace(from_image(frame, UTC, QUALITY), header=raw.header), frame.stamp_ns


def _made(topic: Topic, message: Message, at_ns: int, stamper: Stamper) -> Sample:
    return Sample(topic, encode(message), at_ns + stamper.offset_ns, at_ns)


def _is_told(topic: BagTopic) -> bool:
    """Whether the robot tells it on the bus under the same name."""
    same = TOPICS.get(topic.name.strip("/"))
    return same is not None and same.direction is Direction.OUT and ros_name(same.message) == topic.type_name


def _take(found: Dict[str, Topic], topic: Topic, choose: Callable[[], BagTopic]) -> Optional[BagTopic]:
    """The chosen topic of the bag is that of the bus, and no other is."""
    try:
        chosen = choose()
    except NotThereError:
        return None
    for name in [name for name, planned in found.items() if planned is topic]:
        del found[name]
    found[chosen.name] = topic
    return chosen


def _stamp_ns(bag: Bag, message: BagMessage, topic: Topic) -> int:
    """What its header says; of a message without one, when it was recorded."""
    with naming(bag, message):
        header = getattr(decode(topic.message, message.data), "header", None)
        return message.log_ns if header is None else UTC.to_ns(header.stamp)
