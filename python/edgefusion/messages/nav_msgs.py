# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's nav_msgs, those that are on the bus."""

from dataclasses import dataclass, field

from edgefusion.messages.geometry_msgs import PoseStamped, PoseWithCovariance, TwistWithCovariance
from edgefusion.messages.idl import Message, sequence
from edgefusion.messages.std_msgs import Header


@dataclass(frozen=True)
class Odometry(Message, typename="nav_msgs/msg/Odometry"):
    """pose: in the header's frame; twist: in the child's."""

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass(frozen=True)
class Path(Message, typename="nav_msgs/msg/Path"):
    header: Header = field(default_factory=Header)
    poses: sequence[PoseStamped] = field(default_factory=list)
