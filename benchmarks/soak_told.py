# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a robot is told in a soak: whether it is driven, when it was told to stand, and how long it heard nothing."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from typing import Deque, List, Sequence, Tuple

from edgefusion.drivers.sip_command import Command
from edgefusion.sim.sip_robot_commands import Told

_STANDS = (Command.STOP, Command.E_STOP, Command.OPEN, Command.CLOSE)
_KEPT = 20_000

Heard = Tuple[int, Told]


class ToldWatch:
    """v_mps: what it was told last, 0 for a stop."""

    def __init__(self) -> None:
        self.v_mps = 0.0
        self._zeros_ns: List[int] = []
        self._heard_ns: Deque[int] = deque(maxlen=_KEPT)

    def look(self, heard: Sequence[Heard]) -> None:
        """Of all that the robot has heard, what is new."""
        last_ns = self._heard_ns[-1] if self._heard_ns else 0
        begin = len(heard)
        while begin > 0 and heard[begin - 1][0] > last_ns:
            begin -= 1
        for stamp_ns, told in heard[begin:]:
            self._hear(stamp_ns, told)

    def _hear(self, stamp_ns: int, told: Told) -> None:
        self._heard_ns.append(stamp_ns)
        if told.number in _STANDS or (told.number == Command.VEL and told.value == 0):
            self.v_mps = 0.0
            self._zeros_ns.append(stamp_ns)
        elif told.number == Command.VEL:
            self.v_mps = told.value / 1e3

    def stopped_s(self, since_s: float) -> float | None:
        """From then until it was first told to stand [s]; None where it was not yet."""
        number = bisect_right(self._zeros_ns, since_s * 1e9)
        return self._zeros_ns[number] / 1e9 - since_s if number < len(self._zeros_ns) else None

    def longest_silence_s(self, since_s: float, now_s: float) -> float:
        """Between two commands, or from the last one on, in this time [s]."""
        times_s = [since_s, *(ns / 1e9 for ns in self._heard_ns if since_s < ns / 1e9 <= now_s), now_s]
        return max(later - earlier for earlier, later in zip(times_s, times_s[1:]))
