# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where a Pioneer is, out of counts that wrap, begin anew, and now and then are noise that passed the checksum."""

from __future__ import annotations

import math
from typing import NamedTuple

from edgefusion.drivers.pioneer_factors import Factors
from edgefusion.drivers.sip_status import Status
from edgefusion.types import STILL, Pose2D

TOP_SPEED_MPS, TOP_YAW_RATE_RADPS = 2.2, math.radians(500)
TOP_CHANGE_MPS2 = 4.0
"""No Pioneer goes faster, or brakes harder."""

NEW_COUNTS = 3
"""So many SIPs in a row that follow from each other, but not from what was before, are a robot that began anew."""

_SLACK_M, _SLACK, _SLACK_MPS = 0.1, math.radians(20), 0.2
_WRAP, _HALF = 0x7FFF, 0x4000
_NS_PER_S = 1e9


class Counts(NamedTuple):
    """One SIP's odometry and speed, and when it came."""

    stamp_ns: int
    x: int
    y: int
    heading: int
    speed_mps: float


class Odometry:
    """Adds up the steps between SIPs. pose: in `odom`; it goes on where it was when the robot's counts begin anew."""

    def __init__(self, factors: Factors, pose: Pose2D = STILL) -> None:
        self._factors = factors
        self._last: Counts | None = None
        self._doubtful: Counts | None = None
        self._doubts = 0
        self.pose = pose

    def begin_anew(self) -> None:
        """The next SIP is taken for where the pose is now."""
        self._last = self._doubtful = None
        self._doubts = 0

    def add(self, stamp_ns: int, status: Status) -> bool:
        """Whether the SIP follows from the last one; where it does not, the pose stays."""
        speed_mps = (status.left_speed + status.right_speed) / 2 * self._factors.speed_mps
        counts = Counts(stamp_ns, status.x_counts, status.y_counts, status.heading_counts, speed_mps)
        if self._last is not None and not self._follows(self._last, counts):
            self._doubt(counts)
            return False
        if self._last is not None:
            self.pose = self.pose.compose(self._step(self._last, counts))
        self._last, self._doubtful, self._doubts = counts, None, 0
        return True

    def _doubt(self, counts: Counts) -> None:
        before = self._doubtful
        follows = before is not None and self._follows(before, counts)
        self._doubts = self._doubts + 1 if follows else 1
        self._doubtful = counts
        if self._doubts >= NEW_COUNTS:
            self._last, self._doubtful, self._doubts = counts, None, 0

    def _follows(self, before: Counts, after: Counts) -> bool:
        """Whether a robot gets from one to the other. SIPs may be held up and come at once, so there is some slack."""
        step, dt_s = self._step(before, after), (after.stamp_ns - before.stamp_ns) / _NS_PER_S
        return (
            math.hypot(step.x_m, step.y_m) <= TOP_SPEED_MPS * dt_s + _SLACK_M
            and abs(step.theta) <= TOP_YAW_RATE_RADPS * dt_s + _SLACK
            and abs(after.speed_mps - before.speed_mps) <= TOP_CHANGE_MPS2 * dt_s + _SLACK_MPS
        )

    def _step(self, before: Counts, after: Counts) -> Pose2D:
        """From one to the other, as the robot saw it from the first."""
        x_m = _difference(after.x, before.x) * self._factors.distance_m
        y_m = _difference(after.y, before.y) * self._factors.distance_m
        then, now = before.heading * self._factors.heading, after.heading * self._factors.heading
        return Pose2D(x_m, y_m, math.remainder(now, 2 * math.pi)).relative_to(Pose2D(0.0, 0.0, then))


def _difference(new: int, old: int) -> int:
    """Of counters of 15 bits; less than half a wrap apart."""
    return ((new - old + _HALF) & _WRAP) - _HALF
