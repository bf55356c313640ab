# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's builtin_interfaces."""

from dataclasses import dataclass

from edgefusion.messages.idl import Message, int32, uint32


@dataclass(frozen=True)
class Time(Message, typename="builtin_interfaces/msg/Time"):
    """Since 1970 in UTC; nanosec below a second."""

    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass(frozen=True)
class Duration(Message, typename="builtin_interfaces/msg/Duration"):
    """nanosec below a second, and never negative."""

    sec: int32 = 0
    nanosec: uint32 = 0
