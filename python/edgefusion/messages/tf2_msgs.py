# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's tf2_msgs, those that are on the bus."""

from dataclasses import dataclass, field

from edgefusion.messages.geometry_msgs import TransformStamped
from edgefusion.messages.idl import Message, sequence


@dataclass(frozen=True)
class TFMessage(Message, typename="tf2_msgs/msg/TFMessage"):
    transforms: sequence[TransformStamped] = field(default_factory=list)
