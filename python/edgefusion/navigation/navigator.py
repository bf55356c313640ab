# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives to a goal: where the field leads, by the control law, as far as the guard permits."""

from __future__ import annotations

import math

import numpy.typing as npt

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation import law
from edgefusion.navigation.drive_model import DriveModel, Motion, turned
from edgefusion.navigation.field import Field
from edgefusion.navigation.function_field import FunctionField
from edgefusion.navigation.khatib_field import KhatibField
from edgefusion.navigation.local_frame import LocalFrame
from edgefusion.navigation.manoeuvring import PLANNED, Manoeuvring, first_unfit
from edgefusion.navigation.patience import Patience, Stall
from edgefusion.navigation.progress import Progress, Reason, State
from edgefusion.navigation.steering import Steering
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Goal, Pose2D, Scan, Twist2D

_NS_PER_S = 1e9
SHUT_NS = 3_000_000_000
"""There must be no way for so long before the goal is given up: somebody may just walk past."""

_STILL_MPS, _STILL_RADPS = 0.02, 0.05
_AVOIDED_M = 0.25


class Navigator:
    def __init__(self, navigation: NavigationConfig, base: BaseConfig) -> None:
        self._navigation, self._base = navigation, base
        self._frame, self._drive = LocalFrame(base), DriveModel(base)
        self._surroundings = Surroundings(navigation, base)
        self._stamp_ns: int | None = None
        self._pose = Pose2D()
        self._goal: Goal | None = None

    def step(
        self,
        stamp_ns: int,
        scan: Scan | None,
        pose: Pose2D,
        goal: Goal,
        rear_points_m: npt.ArrayLike | None = None,
    ) -> tuple[Twist2D, Progress]:
        here = self._follow(stamp_ns, pose)
        if self._goal is None or goal.id != self._goal.id:
            self._begin(goal)
        target = self._frame.place(goal.pose)
        self._surroundings.stand(stamp_ns, here, target)
        if scan is not None:
            self._surroundings.see(scan)
        motion = self._drive.ahead(stamp_ns, here)
        self._surroundings.look(stamp_ns + self._drive.delay_ns, motion, rear_points_m)
        if self._ended is None:
            twist, progress = self._towards(stamp_ns, scan, motion, target)
        else:
            twist, progress = Twist2D(), self._ended
        if progress.state in (State.ARRIVED, State.BLOCKED):
            self._ended = progress
        self._drive.commanded(stamp_ns, twist)
        return twist, progress

    def _begin(self, goal: Goal) -> None:
        """Another goal: nothing of the last one is left but the map."""
        navigation, base = self._navigation, self._base
        self._goal, self._there, self._ended = goal, False, None
        self._patience, self._stall = Patience(navigation.patience_s), Stall()
        self._shut_ns: int | None = None
        self._field: Field
        self._manoeuvring: Manoeuvring | None = None
        if navigation.field == "khatib":
            self._field = KhatibField(navigation, base.max_speed_mps)
        else:
            self._field = field = FunctionField(navigation, self._surroundings.footprint.inscribed_m)
            self._manoeuvring = Manoeuvring(self._surroundings, field, base, navigation.margin_m)

    def _follow(self, stamp_ns: int, odometry: Pose2D) -> Pose2D:
        """Where the robot is now in the local frame."""
        if self._stamp_ns is None:
            here = self._frame.enter(odometry, 0.0, Twist2D())
        elif stamp_ns <= self._stamp_ns:
            raise RefusedError(f"stamp_ns: expected more than {self._stamp_ns}, got {stamp_ns}")
        else:
            dt_s = (stamp_ns - self._stamp_ns) / _NS_PER_S
            here = self._frame.enter(odometry, dt_s, self._drive.twist)
            self._drive.moved(self._stamp_ns, stamp_ns, here.relative_to(self._pose))
        self._stamp_ns, self._pose = stamp_ns, here
        return here

    def _towards(self, stamp_ns: int, scan: Scan | None, motion: Motion, target: Pose2D) -> tuple[Twist2D, Progress]:
        """One step to the goal."""
        goal, here, at = self._goal, self._pose, Pose2D(*motion[:3])
        gap_m = self._surroundings.guard.gap((here.x_m, here.y_m, here.theta))
        age_s = math.inf if scan is None else (stamp_ns - scan.stamp_ns) / _NS_PER_S
        if not age_s <= self._navigation.max_scan_age_s:
            return Twist2D(), Progress(goal.id, State.DRIVING, math.inf, gap_m, note="no scan that is new enough")
        self._field.update(self._surroundings, target, goal.position_tolerance_m, here)
        self._there = law.is_there(math.hypot(target.x_m - at.x_m, target.y_m - at.y_m), self._there, goal)
        descent = self._field.descend(at, abs(motion[3]))
        state = State.TURNING if self._there else State.DRIVING
        left_m = math.hypot(target.x_m - here.x_m, target.y_m - here.y_m) if self._there else descent.way_left_m
        if self._there and self._faces(target, here) and self._stands():
            return Twist2D(), Progress(goal.id, State.ARRIVED, left_m, gap_m)
        reason = self._given_up(stamp_ns, left_m + (abs(turned(target.theta, here.theta)) if self._there else 0.0))
        if reason is not None:
            return Twist2D(), Progress(goal.id, State.BLOCKED, left_m, gap_m, reason)
        hold_s = law.CYCLE_S + 0.05 + max(0.0, age_s - 0.05)
        steering = Steering(self._surroundings, self._navigation.margin_m, motion, hold_s)
        twist, note = self._manoeuvre(stamp_ns, steering, at, target)
        if twist is None:
            if descent.direction is None and not self._there:
                return Twist2D(), Progress(goal.id, state, math.inf, gap_m, note="looks for a way")
            wish = self._wish(at, target, descent)
            twist = steering.permitted(wish)
            note = "" if twist == law.as_carried(wish) else "slowed for what is near"
            if self._manoeuvring and wish != Twist2D() and self._stall.step(stamp_ns, here):
                self._stall.reset()
                self._manoeuvring.begin(at, goal, target, self._there)
        return twist, Progress(goal.id, state, left_m, gap_m, note=note)

    def _wish(self, at: Pose2D, target: Pose2D, descent) -> Twist2D:
        if self._there:
            return Twist2D() if self._faces(target, at) else law.turn(turned(target.theta, at.theta), self._base)
        off = descent.direction - at.theta
        speed = min(
            descent.pull * self._base.max_speed_mps, 0.02 + law.approach_speed_mps(descent.way_left_m, self._base)
        )
        return law.drive((math.cos(off), math.sin(off)), speed, self._base)

    def _manoeuvre(self, stamp_ns, steering, at, target):
        m = self._manoeuvring
        if m is None:
            return None, ""
        if m.searching:
            if m.search() is False:
                x, y = first_unfit(self._field, self._surroundings, at, PLANNED * self._navigation.margin_m)
                self._surroundings.map.avoid(x, y, _AVOIDED_M)
            return Twist2D(), "looks for a way out"
        if not m.driving:
            return None, ""
        wish = m.wish(at)
        if wish is None:
            self._there = self._there or m.to_goal  # what is left may be within the goal's tolerance
            return None, ""
        twist = steering.along(wish)
        if self._stall.step(stamp_ns, self._pose):
            self._stall.reset()
            m.drop()
        return twist, "manoeuvres"

    def _faces(self, target: Pose2D, pose: Pose2D) -> bool:
        return (
            abs(turned(target.theta, pose.theta)) < self._goal.heading_tolerance
            or self._goal.heading_tolerance >= math.pi
        )

    def _stands(self) -> bool:
        twist = self._drive.twist
        return abs(twist.v_mps) < _STILL_MPS and abs(twist.w_radps) < _STILL_RADPS

    def _given_up(self, stamp_ns: int, left_m: float) -> Reason | None:
        shut = self._field.shut
        if shut is None:
            self._shut_ns = None
        elif self._shut_ns is None:
            self._shut_ns = stamp_ns
        elif stamp_ns - self._shut_ns > SHUT_NS:
            return shut
        waited = self._patience.waited_ns(stamp_ns, left_m)
        return Reason.NO_PROGRESS if self._patience.is_over(waited) else None
