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
# Where the odometry says otherwise than by so much, the base did not do what it was commanded.
_OFF_MPS, _OFF_RADPS = 0.15, 0.35
# Of a smaller difference so much is believed at every step: odometry comes in whole millimetres.
_TRUST = 0.3
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
        self.twist = Twist2D()

    @property
    def stands(self) -> bool:
        return abs(self.twist.v_mps) < _STILL_MPS and abs(self.twist.w_radps) < _STILL_RADPS

    def commanded(self, stamp_ns: int, twist: Twist2D) -> None:
        """This goes to the base now."""
        self._pending.append((stamp_ns + self.delay_ns, twist))

    def moved(self, before_ns: int, now_ns: int, motion: Pose2D) -> None:
        """The odometry since the last step: corrects what the base was taken to do."""
        state = self._run((0.0, 0.0, 0.0, self.twist.v_mps, self.twist.w_radps), before_ns, now_ns)
        while self._pending and self._pending[0][0] <= now_ns:
            self._obeyed = self._pending.pop(0)[1]
        v_mps, w_radps = state[3], state[4]
        dt_s = (now_ns - before_ns) / _NS_PER_S
        real_v, expected_v = motion.x_m / dt_s, state[0] / dt_s
        real_w, expected_w = motion.theta / dt_s, state[2] / dt_s
        if abs(real_v - expected_v) > _OFF_MPS or abs(real_w - expected_w) > _OFF_RADPS:
            self.twist = Twist2D(real_v, real_w)
        else:
            v_mps, w_radps = v_mps + _TRUST * (real_v - expected_v), w_radps + _TRUST * (real_w - expected_w)
            self.twist = Twist2D(v_mps, w_radps)

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
