# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a simulated Pioneer's firmware gets from one velocity to another."""

from __future__ import annotations


class Ramp:
    """top, top_rate: of the robot, in a unit and a unit per second; a host may only set less, in the same ones."""

    def __init__(self, top: float, top_rate: float) -> None:
        self._most, self._most_rate = top, top_rate
        self._top, self._faster, self._slower = top, top_rate, top_rate
        self._now = 0.0

    def set_top(self, top: float) -> None:
        """The greatest velocity, to either side."""
        self._top = min(abs(top), self._most)

    def set_rate(self, rate: float) -> None:
        """Above 0: how soon it gets faster; below: how soon slower. 0 changes nothing."""
        if rate > 0:
            self._faster = min(rate, self._most_rate)
        elif rate < 0:
            self._slower = min(-rate, self._most_rate)

    def halt(self) -> None:
        """At once."""
        self._now = 0.0

    def towards(self, wanted: float, dt_s: float) -> float:
        """The velocity after so many seconds more."""
        target = max(-self._top, min(self._top, wanted))
        if self._now * target < 0:  # through rest first
            target = 0.0
        rate = self._faster if abs(target) > abs(self._now) else self._slower
        self._now += max(-rate * dt_s, min(rate * dt_s, target - self._now))
        return self._now
