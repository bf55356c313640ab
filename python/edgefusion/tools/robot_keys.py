# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Driving by the keyboard: a key moves the robot for as long as it is repeated."""

from __future__ import annotations

import re
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
_KEY = re.compile(rb"\x1b[\[O][0-9;]{0,8}[^0-9;]|\x1b(?=[^\[O]|[\[O][0-9;]{9})|[^\x1b]", re.DOTALL)
"""A key that is no character is an escape, a bracket, perhaps numbers for what was held with it, and a letter."""


class Keys:
    """speed_mps, yaw_rate_radps: of the keys that drive. quit: once Q was pressed."""

    def __init__(self, speed_mps: float, yaw_rate_radps: float) -> None:
        self._speed_mps, self._yaw_rate_radps = speed_mps, yaw_rate_radps
        self._way, self._pressed_ns = (0, 0), 0
        self._begun = b""
        self.quit = False
        self._motors = False

    def press(self, data: bytes, now_ns: int) -> None:
        """The bytes of a terminal, in any pieces. A key that means nothing stops the robot."""
        data = self._begun + data
        key = _KEY.match(data)
        while key is not None:
            self._key(key.group(), now_ns)
            data = data[key.end() :]
            key = _KEY.match(data)
        self._begun = data

    def let_go(self) -> None:
        """What was pressed is of no account, but for Q."""
        self._way, self._motors = (0, 0), False

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
