# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The robot's clock as a process on another computer reckons with it: its own, and how far the robot's is ahead.

Computers count from their own boots, and their clocks drift apart by some 50 us a second: the robot's is read again and
again, and of the newest readings the most exact one counts.
"""

from __future__ import annotations

from collections import deque
from typing import Deque

from edgefusion.bus.clock_reading import Reading
from edgefusion.clock import Clock, system_clock

KEPT = 8


class RobotClock:
    """A clock like any other, for any thread. own_id: of this computer's; id: of the one that it says."""

    def __init__(self, own_id: str, own: Clock = system_clock) -> None:
        self._own, self._own_id, self._best = own, own_id, Reading(own_id, 0, 0)
        self._readings: Deque[Reading] = deque(maxlen=KEPT)

    def __call__(self) -> int:
        return self.of(self._own())

    @property
    def id(self) -> str:
        return self._best.clock

    @property
    def ahead_ns(self) -> int:
        """So much more than this computer's it says."""
        return self._best.ahead_ns

    @property
    def error_ns(self) -> int:
        """By so much at most it was wrong when it was read; 0 of this computer's own."""
        return self._best.error_ns

    def of(self, own_ns: int) -> int:
        """What it says when this computer's clock says that."""
        return own_ns + self._best.ahead_ns

    def own(self, ns: int) -> int:
        """What this computer's clock says when it says that."""
        return ns - self._best.ahead_ns

    def read(self, reading: Reading) -> None:
        """The newest. The first may be of another clock than this computer's. Raises RuntimeError for one of another
        clock than those before: the robot's computer was started anew, and nothing fits together any more."""
        if self._readings and reading.clock != self._best.clock:
            raise RuntimeError(f"the robot's clock: expected {self._best.clock}, got {reading.clock}: it began anew")
        self._readings.append(Reading(reading.clock, 0, 0) if reading.clock == self._own_id else reading)
        self._best = min(self._readings, key=lambda each: each.error_ns)
