# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The scene's drive as bags: by edgefusion's own writer, and of each kind that the library rosbags writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Iterator, NamedTuple

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from edgefusion.messages import Message, ros_name
from edgefusion.messages.cdr import encode
from edgefusion.messages.definitions import definition
from edgefusion.messages.from_camera_info import from_camera_info
from edgefusion.messages.from_jpeg import from_jpeg
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.transform import FrameTransform, mounting
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile
from scene import FRAMES, HEIGHT, LASER_HEIGHT_M, T_CAMERA_LASER, WIDTH, K

OFFSET_NS = 1_700_000_000_000_000_000
"""UTC of the drive's beginning."""
STAMPER = Stamper(OFFSET_NS)

T_BASE_LASER = np.eye(4)
T_BASE_LASER[2, 3] = LASER_HEIGHT_M

try:
    from rosbags.rosbag2.enums import StoragePlugin
except ImportError:  # the newest rosbags for Python 3.8 writes one kind alone
    SETTINGS = {"ros1": {}, "sqlite": {}}
else:
    SETTINGS = {
        "ros1": {},
        "sqlite": {"version": 9, "storage_plugin": StoragePlugin.SQLITE3},
        "mcap": {"version": 9, "storage_plugin": StoragePlugin.MCAP},
    }


class Sample(NamedTuple):
    """A message to write, and when."""

    topic: str
    message: Message
    log_ns: int


def samples(drive: Path, scan: str = "/scan", image: str = "/image/compressed") -> Iterator[Sample]:
    """All that a bag of the drive has; scans come late, as over a slow line."""
    recording = FolderRecording(drive)
    camera_info = image.replace("/compressed", "").rsplit("/", 1)[0] + "/camera_info"
    transforms = from_transforms(0, mounting(T_BASE_LASER, T_CAMERA_LASER), STAMPER)
    yield Sample("/tf_static", transforms, OFFSET_NS)
    for i in range(FRAMES):
        frame_ns, scan_ns = recording.frame(i).stamp_ns, recording.scan(i).stamp_ns
        jpeg = Path(recording.frame_name(i)).read_bytes()
        info = from_camera_info(frame_ns, Intrinsics((WIDTH, HEIGHT), K), STAMPER)
        yield Sample(image, from_jpeg(frame_ns, jpeg, STAMPER), OFFSET_NS + frame_ns + 1_000_000)
        yield Sample(camera_info, info, OFFSET_NS + frame_ns + 2_000_000)
        yield Sample(scan, from_scan(recording.scan(i), STAMPER), OFFSET_NS + scan_ns + 50_000_000)


def write_ours(path: Path, messages: Iterator[Sample]) -> Path:
    """As `edgefusion record` writes it."""
    writer, channels = McapWriter(RecordFile.create(path)), {}
    for topic, message, log_ns in messages:
        if topic not in channels:
            channels[topic] = writer.add_channel(topic, ros_name(type(message)), definition(type(message)))
        writer.write(channels[topic], encode(message), log_ns, log_ns)
    writer.close()
    return path


def write_theirs(path: Path, messages: Iterator[Sample], kind: str) -> Path:
    """By rosbags; kind: one of SETTINGS."""
    ros2 = get_typestore(Stores.ROS2_HUMBLE)
    store = get_typestore(Stores.ROS1_NOETIC) if kind == "ros1" else ros2
    if kind == "ros1":  # which rosbags does not know there
        tf = "tf2_msgs/msg/TFMessage"
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", tf))
    writer: Any = (Writer1 if kind == "ros1" else Writer2)(path, **SETTINGS[kind])
    with writer:
        connections: dict[str, Any] = {}
        for topic, message, log_ns in messages:
            name = ros_name(type(message))
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            data = encode(message)
            if kind == "ros1":
                data = bytes(ros2.cdr_to_ros1(data, name))
            writer.write(connections[topic], log_ns, data)
    return path


def written_as(kind: str, folder: Path, messages: Iterator[Sample]) -> Path:
    """A new bag of any kind in a folder; "ours" is edgefusion's."""
    if kind == "ours":
        return write_ours(folder / "drive.mcap", messages)
    return write_theirs(folder / ("drive.bag" if kind == "ros1" else f"drive-{kind}"), messages, kind)


KINDS = ("ours", *SETTINGS)
__all__ = ["KINDS", "FrameTransform", "Sample", "samples", "write_ours", "write_theirs", "written_as"]
