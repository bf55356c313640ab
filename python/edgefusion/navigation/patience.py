# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When to try otherwise, and when to give up: clocks that run on stamps."""

from __future__ import annotations

import math

from edgefusion.navigation.drive_model import turned
from edgefusion.types import Pose2D

_NS_PER_S = 1e9


class Stall:
    """Whether the robot has hardly moved or turned for some time, although it wanted to."""

    PLACE_M, TURN, AFTER_S = 0.03, math.radians(6), 0.8

    def __init__(self) -> None:
        self._from: tuple[int, Pose2D] | None = None

    def reset(self) -> None:
        self._from = None

    def step(self, stamp_ns: int, pose: Pose2D) -> bool:
        if self._from is None or self._moved(pose):
            self._from = stamp_ns, pose
        return stamp_ns - self._from[0] >= self.AFTER_S * _NS_PER_S

    def _moved(self, pose: Pose2D) -> bool:
        assert self._from is not None
        before = self._from[1]
        return (
            math.hypot(pose.x_m - before.x_m, pose.y_m - before.y_m) > self.PLACE_M
            or abs(turned(pose.theta, before.theta)) > self.TURN
        )


class Patience:
    """Whether it is time to give up, or, sooner, to try otherwise. Ends: detours are counted."""

    NEARER_M, LONGER_M, MOST_DETOURS = 0.1, 0.3, 60

    def __init__(self, patience_s: float) -> None:
        self._patience_ns = round(patience_s * _NS_PER_S)
        self._best_m = self._last_m = math.inf
        self._since_ns: int | None = None
        self._detours = 0

    def waited_ns(self, stamp_ns: int, left_m: float) -> int:
        """For how long the way that is left has not become shorter, or suddenly longer: a detour to be driven."""
        longer = math.isfinite(left_m) and math.isfinite(self._last_m) and left_m > self._last_m + self.LONGER_M
        if longer:
            self._detours += 1
        if self._since_ns is None or left_m < self._best_m - self.NEARER_M or longer:
            self._since_ns, self._best_m = stamp_ns, left_m
        self._last_m = left_m
        return stamp_ns - self._since_ns

    def is_over(self, waited_ns: int) -> bool:
        return waited_ns > self._patience_ns or self._detours > self.MOST_DETOURS
