# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the encoders at a simulated Pioneer's wheels count."""

from __future__ import annotations

import math
from typing import Tuple

from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE
from edgefusion.types import Pose2D

_WORD = 1 << 32


class WheelTicks:
    """Counts from power-on, forward and back; 32 bits with a sign, which wrap."""

    def __init__(self, ticks_per_mm: int, pose: Pose2D) -> None:
        self._ticks_per_mm, self._pose = ticks_per_mm, pose
        self._left_mm = self._right_mm = 0.0

    def roll_to(self, pose: Pose2D) -> None:
        """Where the odometry has got to; to be told often enough for the way to be straight, or an arc."""
        step = pose.relative_to(self._pose)
        turn = step.theta
        chord_mm = math.copysign(1e3 * math.hypot(step.x_m, step.y_m), step.x_m * math.cos(turn / 2))
        way_mm = chord_mm * (1.0 if turn == 0.0 else turn / 2 / math.sin(turn / 2))
        aside_mm = turn / HALF_WHEEL_BASE
        self._left_mm += way_mm - aside_mm
        self._right_mm += way_mm + aside_mm
        self._pose = pose

    @property
    def ticks(self) -> Tuple[int, int]:
        """Of the left wheel, and of the right one."""
        return self._wrapped(self._left_mm), self._wrapped(self._right_mm)

    def _wrapped(self, way_mm: float) -> int:
        return (round(way_mm * self._ticks_per_mm) + _WORD // 2) % _WORD - _WORD // 2
