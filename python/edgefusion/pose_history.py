# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the robot was a moment ago: what a sensor measured is placed with the pose at the time of measurement."""

from __future__ import annotations

import math
from bisect import bisect_left

from edgefusion.errors import RefusedError
from edgefusion.types import Pose2D

SPAN_NS = 1_000_000_000


class PoseHistory:
    """Poses by stamp, the last second of them by default; between two stamps the pose is interpolated."""

    def __init__(self, span_ns: int = SPAN_NS) -> None:
        self._span_ns = span_ns
        self._stamps_ns: list[int] = []
        self._poses: list[Pose2D] = []

    def add(self, stamp_ns: int, pose: Pose2D) -> None:
        """Raises RefusedError for a stamp that is not after the last one."""
        if self._stamps_ns and stamp_ns <= self._stamps_ns[-1]:
            raise RefusedError(f"stamp_ns: expected more than {self._stamps_ns[-1]}, got {stamp_ns}")
        self._stamps_ns.append(stamp_ns)
        self._poses.append(pose)
        # The newest pose that is as old as the span stays, to interpolate from.
        outdated = bisect_left(self._stamps_ns, stamp_ns - self._span_ns + 1) - 1
        if outdated > 0:
            del self._stamps_ns[:outdated], self._poses[:outdated]

    def at(self, stamp_ns: int) -> Pose2D:
        """The pose at a time that the history covers. Raises RefusedError for any other."""
        if not self._stamps_ns or not self._stamps_ns[0] <= stamp_ns <= self._stamps_ns[-1]:
            covered = f"{self._stamps_ns[0]} to {self._stamps_ns[-1]}" if self._stamps_ns else "no time yet"
            raise RefusedError(f"stamp_ns: the poses cover {covered}, got {stamp_ns}")
        after = bisect_left(self._stamps_ns, stamp_ns)
        if self._stamps_ns[after] == stamp_ns:
            return self._poses[after]
        start_ns, end_ns = self._stamps_ns[after - 1 : after + 1]
        share = (stamp_ns - start_ns) / (end_ns - start_ns)
        return _between(self._poses[after - 1], self._poses[after], share)

    def near(self, stamp_ns: int, slack_ns: int) -> Pose2D | None:
        """The pose at a time, that of the first or last stamp up to so long before or after it; None for any other."""
        if not self._stamps_ns or not self._stamps_ns[0] - slack_ns <= stamp_ns <= self._stamps_ns[-1] + slack_ns:
            return None
        return self.at(min(max(stamp_ns, self._stamps_ns[0]), self._stamps_ns[-1]))


def _between(a: Pose2D, b: Pose2D, share: float) -> Pose2D:
    """On the straight line, turning the short way."""
    turn = math.remainder(b.theta - a.theta, 2 * math.pi)
    return Pose2D(
        a.x_m + share * (b.x_m - a.x_m),
        a.y_m + share * (b.y_m - a.y_m),
        math.remainder(a.theta + share * turn, 2 * math.pi),
    )
