# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where a Pioneer is, out of counts that wrap, begin anew, and now and then are noise that passed the checksum."""

from __future__ import annotations

import math
from typing import NamedTuple

from edgefusion.drivers.pioneer_factors import Factors
from edgefusion.drivers.pioneer_state import twist_of
from edgefusion.drivers.sip_status import Status
from edgefusion.types import STILL, Pose2D

TOP_SPEED_MPS, TOP_YAW_RATE_RADPS = 2.2, math.radians(500)
TOP_CHANGE_MPS2, TOP_YAW_CHANGE_RADPS2 = 2.5, math.radians(400)
"""No Pioneer goes faster, or gets faster in less time. It may stop at once: at a wall."""

NEW_COUNTS = 3
"""So many SIPs in a row that follow from each other, but not from what was before, are a robot that began anew."""

_HELD_UP_S = 0.15
"""SIPs may be held up by so much, and then come at once."""
_SLACK_M, _SLACK = 0.02, math.radians(3)
_WRAP, _HALF = 0x7FFF, 0x4000
_NS_PER_S = 1e9


class Counts(NamedTuple):
    """One SIP's odometry and speeds, and when it was sent."""

    stamp_ns: int
    x: int
    y: int
    heading: int
    speed_mps: float
    yaw_rate_radps: float


class Odometry:
    """Adds up the steps between SIPs. pose: in `odom`; it goes on where it was when the robot's counts begin anew."""

    def __init__(self, factors: Factors, pose: Pose2D = STILL) -> None:
        self._factors = factors
        self._last: Counts | None = None
        self._before: tuple[Counts, Pose2D] | None = None
        self._doubtful: Counts | None = None
        self._doubts = 0
        self.pose = pose

    def begin_anew(self) -> None:
        """The next SIP is taken for where the pose is now."""
        self._last = self._before = self._doubtful = None
        self._doubts = 0

    def add(self, stamp_ns: int, status: Status) -> bool:
        """Whether the SIP follows from the last one; where it does not, the pose stays."""
        counts = self._counts(stamp_ns, status)
        if not self._follows(self._last or counts, counts):
            self._doubt(counts)
            return False
        if self._last is not None:
            self._before = self._last, self.pose
            self.pose = self.pose.compose(self._step(self._last, counts))
        self._last, self._doubtful, self._doubts = counts, None, 0
        return True

    def robot_heading(self, theta: float) -> float:
        """A heading in `odom` as the robot itself counts it [rad]."""
        own = 0.0 if self._last is None else self._last.heading * self._factors.heading
        return theta - self.pose.theta + own

    def _counts(self, stamp_ns: int, status: Status) -> Counts:
        twist = twist_of(status, self._factors)
        place = status.x_counts, status.y_counts, status.heading_counts
        return Counts(stamp_ns, *place, twist.v_mps, twist.w_radps)

    def _doubt(self, counts: Counts) -> None:
        before = self._doubtful
        follows = before is not None and self._follows(before, counts)
        self._doubts = self._doubts + 1 if follows else 1
        self._doubtful = counts
        if self._doubts >= NEW_COUNTS:
            self._believe(counts)

    def _believe(self, counts: Counts) -> None:
        """The last SIP was a lie, where these counts follow from the one before it; else the robot began anew."""
        if self._before is not None and self._follows(self._before[0], counts):
            before, pose = self._before
            self.pose = pose.compose(self._step(before, counts))
        self._last, self._before, self._doubtful, self._doubts = counts, None, None, 0

    def _follows(self, before: Counts, after: Counts) -> bool:
        """Whether a robot gets from one to the other: so far, at the speeds that it says, and to these speeds."""
        step, dt_s = self._step(before, after), (after.stamp_ns - before.stamp_ns) / _NS_PER_S
        v = before.speed_mps, after.speed_mps, TOP_SPEED_MPS, TOP_CHANGE_MPS2
        w = before.yaw_rate_radps, after.yaw_rate_radps, TOP_YAW_RATE_RADPS, TOP_YAW_CHANGE_RADPS2
        return (
            _reached(*v, dt_s)
            and _reached(*w, dt_s)
            and math.hypot(step.x_m, step.y_m) <= _way(*v, dt_s) + _SLACK_M
            and abs(step.theta) <= _way(*w, dt_s) + _SLACK
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


def _reached(before: float, after: float, top: float, change: float, dt_s: float) -> bool:
    """Whether a speed can be had that soon after another."""
    slower = max(min(0.0, before), min(max(0.0, before), after))
    return abs(after) <= top and abs(after - slower) <= change * (dt_s + _HELD_UP_S)


def _way(before: float, after: float, top: float, change: float, dt_s: float) -> float:
    """The farthest that one gets from one speed to another."""
    fastest = min(top, max(abs(before), abs(after)) + change * dt_s / 2)
    return fastest * (dt_s + _HELD_UP_S)
