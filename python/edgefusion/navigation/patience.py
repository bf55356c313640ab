# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When to try otherwise, and when to give up: they go by stamps."""

from __future__ import annotations

import math

from edgefusion.navigation.drive_model import turned
from edgefusion.navigation.progress import Reason
from edgefusion.types import Pose2D

_NS_PER_S = 1e9


class Stall:
    """Whether the robot has hardly moved or turned for some time."""

    PLACE_M, TURN, AFTER_S = 0.03, math.radians(6), 0.8
    STEP_S = 0.1
    """Between two steps at most: who was not asked for longer does not know whether the robot was to move."""

    def __init__(self) -> None:
        self._from: Pose2D | None = None
        self._enough = self.TURN
        self._asked_ns = self._lasted_ns = 0

    def lasts(self, stamp_ns: int, pose: Pose2D, left: float = math.inf) -> bool:
        """Asked at every step in which the robot is to move; the others do not count. left: how far it has to turn
        where it only turns: who is nearly there turns slowly, and half of what is left is enough."""
        if self._from is None or self._moved(self._from, pose):
            self._from, self._lasted_ns = pose, 0
            self._enough = min(self.TURN, left / 2)
        else:
            self._lasted_ns += min(stamp_ns - self._asked_ns, round(self.STEP_S * _NS_PER_S))
        self._asked_ns = stamp_ns
        return self._lasted_ns >= self.AFTER_S * _NS_PER_S

    def _moved(self, before: Pose2D, pose: Pose2D) -> bool:
        place_m = math.hypot(pose.x_m - before.x_m, pose.y_m - before.y_m)
        return place_m > self.PLACE_M or abs(turned(pose.theta, before.theta)) > self._enough


class Shut:
    """Whether there has been no way for so long that it is no passer-by who shuts it."""

    AFTER_S = 3.0

    def __init__(self) -> None:
        self._since_ns: int | None = None

    def lasts(self, stamp_ns: int, reason: Reason | None) -> Reason | None:
        """The reason, once there has been one for long enough without a break."""
        if reason is None:
            self._since_ns = None
        elif self._since_ns is None:
            self._since_ns = stamp_ns
        elif stamp_ns - self._since_ns > self.AFTER_S * _NS_PER_S:
            return reason
        return None


class Patience:
    """Whether the way that is left has not become shorter for so long that the goal is given up.

    A way that is suddenly another is a detour, or a shortcut, to be driven: the patience begins anew then, and for what
    it gets nearer on it. Where the robot gets nowhere meanwhile, that is over once the patience has lasted; and there
    are not detours for ever.
    """

    NEARER_M, JUMP_M, SOMEWHERE_M, MOST_DETOURS = 0.1, 0.3, 0.5, 60

    def __init__(self, patience_s: float) -> None:
        self._patience_ns = round(patience_s * _NS_PER_S)
        self._best_m = self._last_m = math.inf
        self._since_ns: int | None = None
        self._from, self._from_ns = Pose2D(), 0  # where the last detour began, and when
        self._detours = 0
        self._jumped = self._longer = False  # since the last detour began

    def pause(self, ns: int) -> None:
        """So much time does not count."""
        if self._since_ns is not None:
            self._since_ns += ns

    def is_over(self, stamp_ns: int, left_m: float, pose: Pose2D) -> bool:
        """left_m: inf while no way is known."""
        if self._since_ns is None:
            self._since_ns, self._from, self._from_ns = stamp_ns, pose, stamp_ns
        if math.isfinite(left_m):
            self._compare(stamp_ns, left_m, pose)
        return stamp_ns - self._since_ns > self._patience_ns or self._detours > self.MOST_DETOURS

    def _compare(self, stamp_ns: int, left_m: float, pose: Pose2D) -> None:
        jumped = math.isfinite(self._last_m) and abs(left_m - self._last_m) > self.JUMP_M
        self._jumped |= jumped
        self._longer |= jumped and left_m > self._last_m
        self._last_m = left_m
        if not jumped and left_m >= self._best_m - self.NEARER_M:
            return
        self._best_m = left_m
        elsewhere = self._elsewhere(pose)
        if not self._jumped or elsewhere or stamp_ns - self._from_ns <= self._patience_ns:
            self._since_ns = stamp_ns
        if self._jumped and elsewhere:
            self._detours += self._longer
            self._from, self._from_ns = pose, stamp_ns
            self._jumped = self._longer = False

    def _elsewhere(self, pose: Pose2D) -> bool:
        return math.hypot(pose.x_m - self._from.x_m, pose.y_m - self._from.y_m) > self.SOMEWHERE_M
