# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which topics of a bag are the laser and the camera: as asked, by ROS's usual names, or the only ones there are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence, Tuple

from edgefusion.errors import RefusedError
from edgefusion.messages import ros_name
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage, Image, LaserScan
from edgefusion.recording.bag import Bag, BagTopic, table

SCAN_NAMES = ("scan", "base_scan", "laser/scan", "lidar/scan", "front/scan", "scan_front", "laser_scan", "laserscan")

_PICTURES = (
    "image_raw", "camera/image_raw", "camera/color/image_raw", "camera/rgb/image_raw", "usb_cam/image_raw", "image",
    "camera/image", "camera/color/image", "camera/image_color", "image_color",
)  # fmt: skip
IMAGE_NAMES = tuple(name + ending for name in _PICTURES for ending in ("", "/compressed"))
CAMERA_INFO = "camera_info"

DRAWN_OVER = ("annotated/compressed", "inspection/compressed")
"""Pictures that the robot tells of what it found: with boxes drawn in they are not what its camera saw."""


@dataclass(frozen=True)
class TopicNames:
    """Topics to take; None: whichever is found."""

    scan: Optional[str] = None
    image: Optional[str] = None
    camera_info: Optional[str] = None


ANY = TopicNames()


class NotThereError(RefusedError):
    """The bag has no such topic, and none was asked for by name."""


def scan_topic(bag: Bag, names: TopicNames) -> BagTopic:
    """The laser's. Raises RefusedError, which lists the topics."""
    return _choose(bag, "laser scans", "--scan-topic", names.scan, SCAN_NAMES, (ros_name(LaserScan),))


def image_topic(bag: Bag, names: TopicNames) -> BagTopic:
    """The camera's, raw or compressed; pictures that are drawn over only where they were asked for by name.

    Raises RefusedError, which lists the topics.
    """
    types = (ros_name(Image), ros_name(CompressedImage))
    return _choose(bag, "camera images", "--image-topic", names.image, IMAGE_NAMES, types, DRAWN_OVER)


def camera_info_topic(bag: Bag, names: TopicNames, image: BagTopic) -> BagTopic:
    """That of the camera with this image topic. Raises RefusedError, which lists the topics."""
    parts = [part for part in image.name.strip("/").split("/") if part != "compressed"]
    beside = "/".join([*parts[:-1], CAMERA_INFO])
    types = (ros_name(CameraInfo),)
    return _choose(bag, "the camera's calibration", "--camera-info-topic", names.camera_info, (beside,), types)


def _choose(
    bag: Bag,
    what: str,
    option: str,
    asked: Optional[str],
    usual: Sequence[str],
    types: Tuple[str, ...],
    never: Sequence[str] = (),
) -> BagTopic:
    fitting = [topic for topic in bag.topics if topic.type_name in types and topic.messages]
    if asked is not None:
        found = [topic for topic in fitting if topic.name.strip("/") == asked.strip("/")]
        if not found:
            raise RefusedError(
                f"{bag.path}: {asked}: expected a topic of {' or '.join(types)} with messages, found {table(bag)}"
            )
        return found[0]
    fitting = [topic for topic in fitting if not _has_name(topic, never)]
    found = _by_usual_name(fitting, usual) or fitting
    if len(found) == 1:
        return found[0]
    if not found:
        but = f", other than {' and '.join(never)} unless {option} says so" if never else ""
        raise NotThereError(f"{bag.path}: expected a topic of {what} ({' or '.join(types)}{but}), found {table(bag)}")
    several = ", ".join(topic.name for topic in found)
    raise RefusedError(f"{bag.path}: several topics of {what}, {several}: {option} chooses one")


def _has_name(topic: BagTopic, names: Sequence[str]) -> bool:
    """Whether it is one of these, also below a name of the robot's."""
    return any(f"/{topic.name.strip('/')}".endswith(f"/{name}") for name in names)


def _by_usual_name(topics: Sequence[BagTopic], usual: Sequence[str]) -> list[BagTopic]:
    """Those with the first of the usual names that there is; else those with it below a name of their own."""
    for fits in (str.__eq__, lambda name, end: name.endswith(f"/{end}")):
        for end in usual:
            found = [topic for topic in topics if fits(topic.name.strip("/"), end)]
            if found:
                return found
    return []
