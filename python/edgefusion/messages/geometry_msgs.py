# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's geometry_msgs: metres, radians, seconds."""

from dataclasses import dataclass, field

from edgefusion.messages.idl import Message, float64, float64x36
from edgefusion.messages.std_msgs import Header


def _nothing_known() -> float64x36:
    return [0.0] * 36


@dataclass(frozen=True)
class Point(Message, typename="geometry_msgs/msg/Point"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass(frozen=True)
class Vector3(Message, typename="geometry_msgs/msg/Vector3"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass(frozen=True)
class Quaternion(Message, typename="geometry_msgs/msg/Quaternion"):
    """A rotation, of length 1."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass(frozen=True)
class Pose(Message, typename="geometry_msgs/msg/Pose"):
    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass(frozen=True)
class PoseStamped(Message, typename="geometry_msgs/msg/PoseStamped"):
    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)


@dataclass(frozen=True)
class PoseWithCovariance(Message, typename="geometry_msgs/msg/PoseWithCovariance"):
    """covariance: [6, 6] row by row, of x, y, z and the rotations about them."""

    pose: Pose = field(default_factory=Pose)
    covariance: float64x36 = field(default_factory=_nothing_known)


@dataclass(frozen=True)
class Twist(Message, typename="geometry_msgs/msg/Twist"):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass(frozen=True)
class TwistWithCovariance(Message, typename="geometry_msgs/msg/TwistWithCovariance"):
    """covariance: [6, 6] row by row, of the velocities along x, y, z and about them."""

    twist: Twist = field(default_factory=Twist)
    covariance: float64x36 = field(default_factory=_nothing_known)


@dataclass(frozen=True)
class Transform(Message, typename="geometry_msgs/msg/Transform"):
    translation: Vector3 = field(default_factory=Vector3)
    rotation: Quaternion = field(default_factory=Quaternion)


@dataclass(frozen=True)
class TransformStamped(Message, typename="geometry_msgs/msg/TransformStamped"):
    """Maps coordinates of the child's frame into those of the header's."""

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    transform: Transform = field(default_factory=Transform)
