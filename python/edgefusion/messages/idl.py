# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How the types of ROS 2 are written in Python: pycdr2's, under names that type checkers understand, too.

A message is a frozen dataclass of `Message`. Its annotations are evaluated (no `from __future__ import annotations`
there): what goes over the wire is made from them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pycdr2 import IdlStruct as Message

if TYPE_CHECKING:
    from typing import List as sequence

    byte = int
    uint8 = int
    uint32 = int
    int32 = int
    float32 = float
    float64 = float
    float64x9 = sequence[float]
    float64x12 = sequence[float]
    float64x36 = sequence[float]
else:
    from pycdr2.types import array, float32, float64, int32, sequence, typedef, uint8, uint32

    byte = typedef["byte", uint8]
    float64x9, float64x12, float64x36 = (array[float64, length] for length in (9, 12, 36))

__all__ = [
    "Message",
    "byte",
    "float32",
    "float64",
    "float64x9",
    "float64x12",
    "float64x36",
    "int32",
    "ros_name",
    "sequence",
    "uint8",
    "uint32",
]


def ros_name(cls: type[Message]) -> str:
    """The full name of a message's type, as "sensor_msgs/msg/LaserScan"."""
    return str(cls.__idl_typename__)
