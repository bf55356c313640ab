# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives to a goal: where the field leads, as the guard permits."""

from __future__ import annotations

import math

import numpy.typing as npt

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.drive_model import DriveModel, Motion, turned
from edgefusion.navigation.function_field import FunctionField
from edgefusion.navigation.local_frame import LocalFrame
from edgefusion.navigation.progress import Progress, State
from edgefusion.navigation.steering import as_carried, permitted
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Goal, Pose2D, Scan, Twist2D

_NS_PER_S = 1e9
_PERIOD_S = 0.05


class Navigator:
    def __init__(self, navigation: NavigationConfig, base: BaseConfig) -> None:
        self._navigation, self._base = navigation, base
        self._frame, self._drive = LocalFrame(base), DriveModel(base)
        self._surroundings = Surroundings(navigation, base)
        self._field = FunctionField(navigation, self._surroundings.footprint.inscribed_m)
        self._stamp_ns = None
        self._pose = None
        self._goal = None
        self._there = False
        self._ended = None

    def step(self, stamp_ns: int, scan: Scan | None, pose: Pose2D, goal: Goal, rear_points_m: npt.ArrayLike | None = None):
        if self._stamp_ns is not None and stamp_ns <= self._stamp_ns:
            raise RefusedError(f"stamp_ns: expected more than {self._stamp_ns}, got {stamp_ns}")
        if self._goal is None or goal.id != self._goal.id:
            self._goal, self._there, self._ended = goal, False, None
        here = self._follow(stamp_ns, pose)
        target = self._frame.place(goal.pose)
        self._surroundings.stand(stamp_ns, here, target)
        age_s = self._see(stamp_ns, scan)
        motion = self._drive.ahead(stamp_ns, here)
        self._surroundings.look(motion, rear_points_m)
        twist, progress = self._decide(motion, here, target, goal, age_s)
        twist = as_carried(twist)
        self._drive.commanded(stamp_ns, twist)
        return twist, progress

    def _follow(self, stamp_ns, odometry):
        if self._stamp_ns is None:
            here = self._frame.enter(odometry, 0.0, Twist2D())
        else:
            dt_s = (stamp_ns - self._stamp_ns) / _NS_PER_S
            here = self._frame.enter(odometry, dt_s, self._drive.twist)
            self._drive.moved(self._stamp_ns, stamp_ns, here.relative_to(self._pose))
        self._stamp_ns, self._pose = stamp_ns, here
        return here

    def _see(self, stamp_ns, scan):
        if scan is None:
            return math.inf
        self._surroundings.see(scan)
        return (stamp_ns - scan.stamp_ns) / _NS_PER_S

    def _decide(self, motion, here, target, goal, age_s):
        s = self._surroundings
        at = Pose2D(motion[0], motion[1], motion[2])
        gap = s.guard.gap((here.x_m, here.y_m, here.theta))
        left = math.hypot(target.x_m - at.x_m, target.y_m - at.y_m)
        self._there = left < goal.position_tolerance_m * (2 if self._there else 1)
        self._field.update(s, target, goal.position_tolerance_m, here)
        descent = self._field.descend(at, abs(motion[3]))
        if self._ended:
            return Twist2D(), self._ended
        hold_s = _PERIOD_S + 0.05 + max(0.0, min(age_s, 1) - 0.05)
        if self._there:
            off = turned(target.theta, at.theta)
            still = abs(self._drive.twist.v_mps) < 0.02 and abs(self._drive.twist.w_radps) < 0.05
            if abs(off) < goal.heading_tolerance and still:
                self._ended = Progress(goal.id, State.ARRIVED, left, gap)
                return Twist2D(), self._ended
            if goal.heading_tolerance >= math.pi:
                off = 0.0
            wish = Twist2D(0.0, self._yaw_rate(off))
            twist = permitted(s, motion, wish, hold_s) or Twist2D()
            return twist, Progress(goal.id, State.TURNING, left, gap)
        if descent.direction is None:
            return Twist2D(), Progress(goal.id, State.DRIVING, math.inf, gap, note="no way")
        off = turned(descent.direction, at.theta)
        v = self._base.max_speed_mps * max(0.0, math.cos(off)) ** 2 if abs(off) < 1.0 else 0.0
        v = min(v, math.sqrt(2 * 0.8 * self._base.acceleration_mps2 * max(0.0, left)))
        wish = Twist2D(v, self._yaw_rate(off))
        twist = permitted(s, motion, wish, hold_s) or Twist2D()
        note = "" if twist == as_carried(wish) else "slowed"
        return twist, Progress(goal.id, State.DRIVING, descent.way_left_m, gap, note=note)

    def _yaw_rate(self, off):
        top = min(self._base.max_yaw_rate_radps, math.sqrt(2 * 0.7 * self._base.yaw_acceleration_radps2 * abs(off)))
        return max(-top, min(top, 2.5 * off))
