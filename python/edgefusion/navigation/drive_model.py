# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the base will be when the command that is worked out now reaches its wheels."""

from __future__ import annotations

import math
from typing import Tuple

from edgefusion._core import followed
from edgefusion.config import BaseConfig
from edgefusion.types import Pose2D, Twist2D

Motion = Tuple[float, float, float, float, float]
"""x, y [m], theta [rad], v [m/s], w [rad/s]."""

_STILL_MPS, _STILL_RADPS = 0.02, 0.05
# What the base was taken to do is compared with the odometry over so long: that of a P3-DX comes every 100 ms.
_WINDOW_S = 0.4
# Where the odometry says otherwise by so much, the base did not do what it was commanded.
_OFF_MPS, _OFF_RADPS = 0.15, 0.35
# Of a smaller difference so much is believed at every step.
_TRUST = 0.1
_NS_PER_S = 1e9


class DriveModel:
    """Knows the commands on their way, and what the base makes of them.

    delay_ns: until a command takes effect. twist: how fast the base is now.
    """

    def __init__(self, base: BaseConfig) -> None:
        self._ramps = (base.acceleration_mps2, base.yaw_acceleration_radps2)
        self.delay_ns = round(base.command_delay_s * _NS_PER_S)
        self._pending: list[tuple[int, Twist2D]] = []  # when each takes effect
        self._obeyed = Twist2D()
        self._window: list[tuple[int, float, float, float, float]] = []
        self._real = Twist2D()
        self.twist = Twist2D()

    @property
    def stands(self) -> bool:
        """As far as is known, and for a while by the odometry."""
        both = self.twist, self._real
        return all(abs(t.v_mps) < _STILL_MPS and abs(t.w_radps) < _STILL_RADPS for t in both)

    def commanded(self, stamp_ns: int, twist: Twist2D) -> None:
        """This goes to the base now."""
        self._pending.append((stamp_ns + self.delay_ns, twist))

    def sent(self, twist: Twist2D) -> None:
        """What really went to the base instead of the last command."""
        if self._pending:
            self._pending[-1] = (self._pending[-1][0], twist)

    def moved(self, before_ns: int, now_ns: int, motion: Pose2D) -> None:
        """The odometry since the last step: corrects what the base was taken to do."""
        state = self._run((0.0, 0.0, 0.0, self.twist.v_mps, self.twist.w_radps), before_ns, now_ns)
        while self._pending and self._pending[0][0] <= now_ns:
            self._obeyed = self._pending.pop(0)[1]
        self._window.append((before_ns, motion.x_m, motion.theta, motion.x_m - state[0], motion.theta - state[2]))
        self._window = [entry for entry in self._window if now_ns - entry[0] <= _WINDOW_S * _NS_PER_S] or [
            self._window[-1]
        ]
        span_s = (now_ns - self._window[0][0]) / _NS_PER_S
        way_m, turn, off_m, off = (sum(entry[i] for entry in self._window) for i in range(1, 5))
        self._real = Twist2D(way_m / span_s, turn / span_s)
        if abs(off_m) / span_s > _OFF_MPS or abs(off) / span_s > _OFF_RADPS:
            self.twist = self._real
        else:
            self.twist = Twist2D(state[3] + _TRUST * off_m / span_s, state[4] + _TRUST * off / span_s)

    def ahead(self, now_ns: int, pose: Pose2D) -> Motion:
        """When the next command takes effect."""
        start = (pose.x_m, pose.y_m, pose.theta, self.twist.v_mps, self.twist.w_radps)
        return self._run(start, now_ns, now_ns + self.delay_ns)

    def _run(self, state: Motion, from_ns: int, to_ns: int) -> Motion:
        """From one time to another, through the commands that take effect meanwhile."""
        command = self._obeyed
        for effect_ns, twist in self._pending:
            if effect_ns > from_ns:
                until_ns = min(effect_ns, to_ns)
                state = self._follow(state, command, until_ns - from_ns)
                from_ns = until_ns
            if effect_ns > to_ns:
                break
            command = twist
        return self._follow(state, command, to_ns - from_ns)

    def _follow(self, state: Motion, command: Twist2D, duration_ns: int) -> Motion:
        if duration_ns <= 0:
            return state
        return followed(state, command.v_mps, command.w_radps, *self._ramps, duration_ns / _NS_PER_S)


def turned(a: float, b: float) -> float:
    """The turn from direction b to a, in [-pi, pi]."""
    return math.remainder(a - b, 2 * math.pi)
