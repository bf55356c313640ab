# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Driving by the keyboard: a key moves the robot for as long as it is repeated."""

from __future__ import annotations

from typing import Dict, Tuple

from edgefusion.types import Twist2D

HELD_NS = 300_000_000
"""A key that was not repeated for so long was let go."""

HELP = (
    "arrows or W A S D drive, space stops, M: motors on or off, Q quits",
    "let go, and it stops within 0.3 s; nothing else looks where it goes",
)

_FORWARD, _BACK, _LEFT, _RIGHT = (1, 0), (-1, 0), (0, 1), (0, -1)
_WAYS: Dict[bytes, Tuple[int, int]] = {
    **{b"w": _FORWARD, b"s": _BACK, b"a": _LEFT, b"d": _RIGHT},
    **{b"\x1b[A": _FORWARD, b"\x1b[B": _BACK, b"\x1b[D": _LEFT, b"\x1b[C": _RIGHT},
    **{b"\x1bOA": _FORWARD, b"\x1bOB": _BACK, b"\x1bOD": _LEFT, b"\x1bOC": _RIGHT},
}
_ESCAPE = 0x1B
_ARROW_BYTES = 3


class Keys:
    """speed_mps, yaw_rate_radps: of the keys that drive. quit: once Q was pressed; motors_switched: since it was asked
    for last."""

    def __init__(self, speed_mps: float, yaw_rate_radps: float) -> None:
        self._speed_mps, self._yaw_rate_radps = speed_mps, yaw_rate_radps
        self._way, self._pressed_ns = (0, 0), 0
        self._begun = b""
        self.quit = False
        self._motors = False

    def press(self, data: bytes, now_ns: int) -> None:
        """The bytes of a terminal, in any pieces. A key that means nothing stops the robot."""
        data = self._begun + data
        self._begun = b""
        while data:
            size = _ARROW_BYTES if data[0] == _ESCAPE else 1
            if size > len(data):
                self._begun = data
                return
            self._key(data[:size], now_ns)
            data = data[size:]

    def twist(self, now_ns: int) -> Twist2D:
        """What the robot is to do now."""
        if now_ns - self._pressed_ns >= HELD_NS:
            self._way = 0, 0
        forward, left = self._way
        return Twist2D(forward * self._speed_mps, left * self._yaw_rate_radps)

    def motors_switched(self) -> bool:
        """Whether M was pressed since the last time."""
        switched, self._motors = self._motors, False
        return switched

    def _key(self, key: bytes, now_ns: int) -> None:
        self._way, self._pressed_ns = _WAYS.get(key.lower() if len(key) == 1 else key, (0, 0)), now_ns
        self.quit |= key.lower() == b"q"
        self._motors |= key.lower() == b"m"
