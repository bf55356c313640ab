# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's diagnostic_msgs, those that are on the bus."""

from dataclasses import dataclass, field

from edgefusion.messages.idl import Message, byte, sequence
from edgefusion.messages.std_msgs import Header


@dataclass(frozen=True)
class KeyValue(Message, typename="diagnostic_msgs/msg/KeyValue"):
    key: str = ""
    value: str = ""


@dataclass(frozen=True)
class DiagnosticStatus(Message, typename="diagnostic_msgs/msg/DiagnosticStatus"):
    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3

    level: byte = 0
    name: str = ""
    message: str = ""
    hardware_id: str = ""
    values: sequence[KeyValue] = field(default_factory=list)


@dataclass(frozen=True)
class DiagnosticArray(Message, typename="diagnostic_msgs/msg/DiagnosticArray"):
    header: Header = field(default_factory=Header)
    status: sequence[DiagnosticStatus] = field(default_factory=list)
