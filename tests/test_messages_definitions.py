# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Definitions of messages, as text."""

from __future__ import annotations

from edgefusion.messages import ros_name
from edgefusion.messages.definitions import definition
from edgefusion.messages.diagnostic_msgs import DiagnosticStatus
from edgefusion.messages.geometry_msgs import PoseWithCovariance
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage
from edgefusion.messages.std_msgs import Header
from edgefusion.messages.vision_msgs import BoundingBox2D

LINE = "=" * 80


def test_a_definition_is_followed_by_those_of_what_it_contains() -> None:
    assert definition(Header).splitlines() == [
        "builtin_interfaces/Time stamp",
        "string frame_id",
        LINE,
        "MSG: builtin_interfaces/Time",
        "int32 sec",
        "uint32 nanosec",
    ]


def test_a_box_is_that_of_vision_msgs_since_its_version_4_1() -> None:
    assert definition(BoundingBox2D).splitlines() == [
        "vision_msgs/Pose2D center",
        "float64 size_x",
        "float64 size_y",
        LINE,
        "MSG: vision_msgs/Pose2D",
        "vision_msgs/Point2D position",
        "float64 theta",
        LINE,
        "MSG: vision_msgs/Point2D",
        "float64 x",
        "float64 y",
    ]


def test_arrays_sequences_and_constants_are_as_in_msg_files() -> None:
    assert "float64[36] covariance" in definition(PoseWithCovariance).splitlines()
    assert {"float64[] d", "float64[9] k"} <= set(definition(CameraInfo).splitlines())
    assert "uint8[] data" in definition(CompressedImage).splitlines()
    assert definition(DiagnosticStatus).splitlines()[:5] == [
        "byte OK=0", "byte WARN=1", "byte ERROR=2", "byte STALE=3", "byte level",
    ]  # fmt: skip


def test_a_type_is_called_as_in_ros_2() -> None:
    assert ros_name(CameraInfo) == "sensor_msgs/msg/CameraInfo"
