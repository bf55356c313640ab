# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where a bag says that its camera and its laser are, and what the camera makes of what it sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.messages import Message, ros_name
from edgefusion.messages.cdr import decode
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage, Image, LaserScan
from edgefusion.messages.to_camera_info import to_camera_info
from edgefusion.recording.bag import Bag, BagTopic, naming
from edgefusion.recording.bag_recording import BagRecording
from edgefusion.recording.frame_tree import FrameTree, read_tree
from edgefusion.recording.topic_choice import camera_info_topic

BASE_FRAMES = ("base_footprint", "base_link")
"""The robot's on the ground; base_footprint is there where base_link is not."""

Matrix = npt.NDArray[np.float64]
M = TypeVar("M", bound=Message)


@dataclass(frozen=True)
class SensorGeometry:
    """T_camera_laser [4, 4] maps laser into camera coordinates, T_base_laser [4, 4] laser into the robot's, whose
    origin is taken to be on the ground. source: what it is from, for people."""

    camera: Intrinsics
    T_camera_laser: Matrix
    T_base_laser: Matrix
    source: str


def read_geometry(recording: BagRecording) -> SensorGeometry:
    """From camera_info and the static transforms. Raises RefusedError that names what is missing."""
    bag, image = recording.bag, recording.image_topic
    info_topic = camera_info_topic(bag, recording.names, image)
    info = _first(bag, info_topic, CameraInfo)
    laser = frame_id_of(bag, recording.scan_topic)
    camera = frame_id_of(bag, image) or info.header.frame_id
    tree = read_tree(bag)
    base = next((frame for frame in BASE_FRAMES if tree.transform(frame, laser) is not None), BASE_FRAMES[-1])
    return SensorGeometry(
        _intrinsics(bag, info_topic, info, image),
        _transform(bag, tree, camera, laser),
        _transform(bag, tree, base, laser),
        f"{info_topic.name} and the transforms of {laser}, {camera} and {base}",
    )


def frame_id_of(bag: Bag, topic: BagTopic) -> str:
    """The frame of a topic of scans or images, as its first message says it. Raises RefusedError."""
    if topic.type_name == ros_name(LaserScan):
        return _first(bag, topic, LaserScan).header.frame_id
    if topic.type_name == ros_name(Image):
        return _first(bag, topic, Image).header.frame_id
    return _first(bag, topic, CompressedImage).header.frame_id


def _first(bag: Bag, topic: BagTopic, cls: type[M]) -> M:
    for message in bag.read({topic.name}):
        with naming(bag, message):
            return decode(cls, message.data)
    raise RefusedError(f"{bag.path}: {topic.name}: expected a message, found none")


def _intrinsics(bag: Bag, topic: BagTopic, info: CameraInfo, image: BagTopic) -> Intrinsics:
    try:
        if "rect" not in image.name:
            return to_camera_info(info)
        return Intrinsics((info.width, info.height), np.reshape(info.p, (3, 4))[:, :3])
    except ValueError as error:
        raise RefusedError(f"{bag.path}: {topic.name}: {error}") from error


def _transform(bag: Bag, tree: FrameTree, into: str, of: str) -> Matrix:
    T = tree.transform(into, of)
    if T is None:
        known = ", ".join(tree.frames) or "none"
        raise RefusedError(
            f"{bag.path}: expected static transforms between {into!r} and {of!r}, found the frames {known}: "
            "--calibration gives a file instead"
        )
    return T
