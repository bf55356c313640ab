# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a host's packets tell a simulated Pioneer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from edgefusion.drivers.sip_frame import Packet

_NON_NEGATIVE, _NEGATIVE, _TEXT = 0x3B, 0x1B, 0x2B


@dataclass(frozen=True)
class Told:
    """A command's number, and its argument: an integer, bytes, or None."""

    number: int
    argument: Union[int, bytes, None] = None

    @property
    def value(self) -> int:
        """The argument as an integer; 0 where it is none."""
        return self.argument if isinstance(self.argument, int) else 0

    @property
    def text(self) -> bytes:
        """The argument as bytes; none where it is no text."""
        return self.argument if isinstance(self.argument, bytes) else b""

    @property
    def on(self) -> bool:
        """Whether it switches something on; so does one without an argument."""
        return self.argument is None or bool(self.argument)


def told(packet: Packet) -> Told:
    """A command that is cut short has no argument: some hosts send SETO so."""
    body = packet.body
    if len(body) >= 4 and body[1] in (_NON_NEGATIVE, _NEGATIVE):
        value = int.from_bytes(body[2:4], "little")
        return Told(body[0], -value if body[1] == _NEGATIVE else value)
    if len(body) >= 3 and body[1] == _TEXT:
        return Told(body[0], _text(body[2:]))
    return Told(body[0])


def _text(argument: bytes) -> bytes:
    """Most hosts send its length first, some with a zero byte behind it, some the zero byte alone."""
    length, text = argument[0], argument[1:]
    if text[length:] not in (b"", b"\0") and argument.endswith(b"\0"):
        return argument[:-1]
    return text[:length]


def wheels_of(value: int) -> tuple[int, int]:
    """The left and the right wheel's steps of VEL2: the two bytes of the integer, each with its sign."""
    word = value & 0xFFFF
    left, right = word >> 8, word & 0xFF
    return left - 256 if left > 127 else left, right - 256 if right > 127 else right
