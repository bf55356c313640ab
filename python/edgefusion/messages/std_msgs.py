# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's std_msgs."""

from dataclasses import dataclass, field

from edgefusion.messages.builtin_interfaces import Time
from edgefusion.messages.idl import Message, float32


@dataclass(frozen=True)
class Header(Message, typename="std_msgs/msg/Header"):
    """When and in which frame."""

    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass(frozen=True)
class String(Message, typename="std_msgs/msg/String"):
    """Text; on our bus it is JSON."""

    data: str = ""


@dataclass(frozen=True)
class ColorRGBA(Message, typename="std_msgs/msg/ColorRGBA"):
    """Each from 0 to 1; an alpha of 1 is opaque."""

    r: float32 = 0.0
    g: float32 = 0.0
    b: float32 = 0.0
    a: float32 = 0.0
