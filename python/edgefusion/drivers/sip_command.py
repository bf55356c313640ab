# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the host says to a Pioneer: the packets of its commands."""

from __future__ import annotations

from enum import IntEnum

from edgefusion.drivers.sip_frame import frame
from edgefusion.errors import RefusedError

MAX_TEXT_BYTES = 197
"""Firmware takes bodies of up to 200 bytes."""

_NON_NEGATIVE, _NEGATIVE, _TEXT = 0x3B, 0x1B, 0x2B


class Command(IntEnum):
    """Numbers of the commands that a base needs. In a closed session 0, 1 and 2 are the steps of the handshake."""

    PULSE = 0
    OPEN = 1
    CLOSE = 2
    ENABLE = 4
    SETA = 5
    SETV = 6
    SETO = 7
    SETRV = 10
    VEL = 11
    HEAD = 12
    DHEAD = 13
    CONFIG = 18
    RVEL = 21
    SETRA = 23
    SONAR = 28
    STOP = 29
    DIGOUT = 30
    VEL2 = 32
    BUMPSTALL = 44
    HOSTBAUD = 50
    E_STOP = 55


def command(number: int, argument: int | bytes | None = None) -> bytes:
    """The packet of a command. An integer goes as its magnitude, the sign in the argument's type.

    Raises RefusedError for a number or an argument that no packet can hold.
    """
    if not 0 <= number <= 0xFF:
        raise RefusedError(f"command: expected 0 to 255, got {number}")
    if argument is None:
        return frame(bytes([number]))
    if isinstance(argument, bytes):
        if len(argument) > MAX_TEXT_BYTES:
            raise RefusedError(f"command {number}: expected up to {MAX_TEXT_BYTES} bytes, got {len(argument)}")
        return frame(bytes([number, _TEXT, len(argument)]) + argument)
    if not -0xFFFF <= argument <= 0xFFFF:
        raise RefusedError(f"command {number}: expected an integer of -65535 to 65535, got {argument}")
    sign = _NEGATIVE if argument < 0 else _NON_NEGATIVE
    return frame(bytes([number, sign]) + abs(argument).to_bytes(2, "little"))


def wheel_speeds(left_mmps: float, right_mmps: float, divisor_mmps: int = 20) -> bytes:
    """The packet of VEL2: each wheel's speed in steps of the divisor, in the two bytes of one integer.

    Raises RefusedError for a speed beyond the 127 steps that a byte holds.
    """
    left, right = round(left_mmps / divisor_mmps), round(right_mmps / divisor_mmps)
    for wheel, steps in (("left", left), ("right", right)):
        if not -128 <= steps <= 127:
            raise RefusedError(f"{wheel} wheel: expected -128 to 127 steps of {divisor_mmps} mm/s, got {steps}")
    both = (left & 0xFF) << 8 | right & 0xFF
    return command(Command.VEL2, both - 0x10000 if both & 0x8000 else both)
