# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A bag as if its robot had told a calibration, instead of what it has of its own."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, AbstractSet, Any, Iterator, List, Mapping, Optional

from edgefusion.bus.topics import CAMERA_INFO, IMAGE, SCAN, TF, TF_STATIC, Topic
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.frames import BASE_LINK, CAMERA_OPTICAL, LASER
from edgefusion.messages.from_camera_info import from_camera_info
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.transform import FrameTransform, mounting
from edgefusion.recording.bag import Bag
from edgefusion.recording.bag_geometry import frame_id_of
from edgefusion.recording.bag_recording import UTC
from edgefusion.recording.frame_tree import plain
from edgefusion.tools.replay_samples import Sample, bag_samples

if TYPE_CHECKING:
    from edgefusion.perception.calibration import Calibration


class CalibratedBag:
    """planned: topics of the bag and those of the bus, without camera_info.

    Raises RefusedError where the frames of its scans and images leave no place for a calibration.
    """

    def __init__(self, bag: Bag, planned: Mapping[str, Topic], calibration: Calibration) -> None:
        self._bag, self._planned = bag, dict(planned)
        self._mounted = _mounting(bag, planned, calibration)
        self._latencies_ns = {SCAN: calibration.laser_latency_ns, IMAGE: calibration.camera_latency_ns}
        self._intrinsics = Intrinsics(calibration.image_size, calibration.K, calibration.distortion)

    def samples(self) -> Iterator[Sample]:
        """The messages of these topics, stamped with when they were captured; camera_info with every image, and
        tf_static, are the calibration's. Of the bag's own transforms stay those of other frames than the laser's and
        the camera's. Raises RefusedError for a message that is none.
        """
        laser, camera = (each.child for each in self._mounted)
        is_told = False
        for sample in bag_samples(self._bag, self._planned):
            if not is_told:
                yield _static(sample.at_ns, self._mounted)
                is_told = True
            if sample.topic in (TF, TF_STATIC):
                yield from _without(sample, {laser, camera})
                continue
            captured = _captured(sample, self._latencies_ns.get(sample.topic, 0))
            if sample.topic is IMAGE:
                yield _info(captured, self._intrinsics, camera)
            yield captured


def _mounting(bag: Bag, planned: Mapping[str, Topic], calibration: Calibration) -> List[FrameTransform]:
    """The laser on the robot and the camera at the laser, by the names of the frames that the bag has for them."""
    laser = _frame(bag, planned, SCAN) or LASER
    camera = _frame(bag, planned, IMAGE) or CAMERA_OPTICAL
    if len({BASE_LINK, laser, camera}) < 3:
        raise RefusedError(
            f"{bag.path}: --calibration: expected scans and images of a frame each, other than {BASE_LINK}, found "
            f"{laser} and {camera}"
        )
    of_laser, of_camera = mounting(calibration.T_base_laser, calibration.T_camera_laser)
    return [replace(of_laser, child=laser), replace(of_camera, parent=laser, child=camera)]


def _frame(bag: Bag, planned: Mapping[str, Topic], wanted: Topic) -> Optional[str]:
    found = [topic for topic in bag.topics if planned.get(topic.name) is wanted and topic.messages]
    return plain(frame_id_of(bag, found[0])) if found else None


def _static(at_ns: int, mounted: List[FrameTransform]) -> Sample:
    return Sample(TF_STATIC, encode(from_transforms(at_ns, mounted, UTC)), at_ns, at_ns)


def _without(sample: Sample, frames: AbstractSet[str]) -> Iterator[Sample]:
    """Its transforms of other frames, where it has any."""
    transforms = decode(TFMessage, sample.payload).transforms
    kept = [each for each in transforms if plain(each.child_frame_id) not in frames]
    if kept:
        yield sample._replace(payload=encode(TFMessage(kept)))


def _captured(sample: Sample, latency_ns: int) -> Sample:
    """Stamped with when it was captured."""
    if not latency_ns:
        return sample
    message: Any = decode(sample.topic.message, sample.payload)  # a scan or an image, which have a header
    stamp_ns = max(sample.stamp_ns - latency_ns, 0)  # of bags whose time begins at 0
    captured = replace(message, header=UTC.header(stamp_ns, message.header.frame_id))
    return sample._replace(payload=encode(captured), stamp_ns=stamp_ns)


def _info(image: Sample, intrinsics: Intrinsics, frame_id: str) -> Sample:
    info = from_camera_info(image.stamp_ns, intrinsics, UTC)
    info = replace(info, header=UTC.header(image.stamp_ns, frame_id))
    return Sample(CAMERA_INFO, encode(info), image.stamp_ns, image.at_ns)
