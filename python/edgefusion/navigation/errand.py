# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One goal, from when it is given until the robot is there or gives it up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.navigation import law
from edgefusion.navigation.drive_model import Motion, turned
from edgefusion.navigation.field import Descent, Field
from edgefusion.navigation.function_field import FunctionField
from edgefusion.navigation.khatib_field import KhatibField
from edgefusion.navigation.manoeuvring import Manoeuvring
from edgefusion.navigation.patience import Patience, Shut, Stall
from edgefusion.navigation.progress import Progress, Reason, State
from edgefusion.navigation.steering import Steering
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Goal, Pose2D, Twist2D

Floats = npt.NDArray[np.float64]

_SPARE_S = 0.05
"""A command may be followed for so much longer than a cycle before the next one comes."""

_CREEP_MPS = 0.02
"""The last bit to the goal is driven with this much, or it would never be reached."""


@dataclass(frozen=True)
class Now:
    """The robot at one step, in the local frame.

    here: where it is; ahead: its motion when the next command takes effect; target: the goal. scan_age_s: of the newest
    scan on the map, inf where there is none. stands: whether the wheels do. held: whether others keep it from
    driving as it answers.
    """

    stamp_ns: int
    here: Pose2D
    ahead: Motion
    target: Pose2D
    scan_age_s: float
    stands: bool
    held: bool

    @property
    def pose_ahead(self) -> Pose2D:
        return Pose2D(*self.ahead[:3])


class Errand:
    """Answers every step with a velocity and how far it has got; after the end with zero and how it ended."""

    def __init__(self, goal: Goal, navigation: NavigationConfig, base: BaseConfig, surroundings: Surroundings) -> None:
        self.goal = goal
        self._navigation, self._base, self._surroundings = navigation, base, surroundings
        self._patience, self._stall, self._shut = Patience(navigation.patience_s), Stall(), Shut()
        self._there = False
        self._last_ns: int | None = None
        self._field: Field
        self._manoeuvring: Manoeuvring | None = None
        self._ended: Progress | None = None
        if navigation.field == "khatib":
            self._field = KhatibField(navigation, base.max_speed_mps)
        else:
            self._field = field = FunctionField(navigation, surroundings.footprint.inscribed_m)
            self._manoeuvring = Manoeuvring(surroundings, field, base, navigation.margin_m)

    def step(self, now: Now) -> Tuple[Twist2D, Progress]:
        """The velocity to drive with from now on."""
        if self._ended is not None:
            return Twist2D(), self._ended
        blind = self._blind(now)
        if blind or now.held:  # by what it cannot help: nothing of that is its lack of progress
            self._patience.pause(now.stamp_ns - (self._last_ns or now.stamp_ns))
            self._stall, self._shut = Stall(), Shut()
        self._last_ns = now.stamp_ns
        if blind:
            return Twist2D(), self._progress(now, State.DRIVING, math.inf, note=blind)
        self._field.update(self._surroundings, now.target, self.goal.position_tolerance_m, now.here)
        self._there = law.is_there(_apart_m(now.target, now.pose_ahead), self._there, self.goal)
        descent = self._field.descend(now.pose_ahead, abs(now.ahead[3]))
        if self._there:
            apart_m = _apart_m(now.target, now.here)
            descent = replace(descent, left_m=apart_m, way_left_m=apart_m)
        self._ended = self._ending(now, descent)
        if self._ended is not None:
            return Twist2D(), self._ended
        twist, note = self._drive(now, descent)
        state = State.TURNING if self._there else State.DRIVING
        return twist, self._progress(now, state, descent.way_left_m, note=note)

    def _blind(self, now: Now) -> str:
        """Why it may not move, whatever the field says; empty where it may."""
        if not now.scan_age_s <= self._navigation.max_scan_age_s:
            return "no scan that is new enough"
        if self._surroundings.touched(now.here):
            return "something is inside the hull"
        return ""

    def way(self, pose: Pose2D, length_m: float) -> Floats:
        """What lies ahead of the way [k, 2], in the local frame; empty for a field that plans none."""
        return self._field.way(pose, length_m)

    def _ending(self, now: Now, descent: Descent) -> Progress | None:
        """How it has ended; None where it goes on."""
        off = self._off(now.here, now.target)
        tolerance = self.goal.heading_tolerance
        if self._there and now.stands and off <= tolerance:
            turned_enough = off <= tolerance / 2 or self._stall.lasts(now.stamp_ns, now.here, off)  # as far as it can
            if turned_enough:
                return self._progress(now, State.ARRIVED, descent.way_left_m)
        reason = self._shut.lasts(now.stamp_ns, self._field.shut)
        left_m = descent.left_m + (off if self._there else 0.0)
        if reason is None and self._patience.is_over(now.stamp_ns, left_m, now.here):
            reason = Reason.NO_PROGRESS
        return None if reason is None else self._progress(now, State.BLOCKED, descent.way_left_m, reason)

    def _drive(self, now: Now, descent: Descent) -> Tuple[Twist2D, str]:
        """By a manoeuvre where one is under way; else where the field leads."""
        hold_s = law.CYCLE_S + _SPARE_S + max(0.0, now.scan_age_s - _SPARE_S)
        steering = Steering(self._surroundings, self._navigation.margin_m, now.ahead, hold_s)
        if self._manoeuvring is not None and self._manoeuvring.active:
            twist = self._manoeuvring.step(now.stamp_ns, now.pose_ahead, steering)
            if twist is not None:
                return twist, "manoeuvres" if self._manoeuvring.driving else "looks for a way out"
            self._there = self._there or self._manoeuvring.to_goal  # what is left may be within the tolerance
        wish = self._wish(now, descent)
        if wish is None:
            return Twist2D(), "looks for a way"
        twist = steering.permitted(wish)
        left = self._off(now.here, now.target) if self._there else math.inf
        if self._manoeuvring is not None and wish != Twist2D() and self._stall.lasts(now.stamp_ns, now.here, left):
            self._stall = Stall()
            self._manoeuvring.begin(now.pose_ahead, self.goal, now.target, self._there)
        return twist, "" if twist == law.as_carried(wish) else "slowed for what is near"

    def _wish(self, now: Now, descent: Descent) -> Twist2D | None:
        """What the control law makes of the field, were nothing in the way; None where there is no way."""
        at = now.pose_ahead
        if self._there:
            turns = self._off(at, now.target) > self.goal.heading_tolerance / 2
            return law.turn(turned(now.target.theta, at.theta), self._base) if turns else Twist2D()
        if descent.direction is None:
            return None
        off = descent.direction - at.theta
        arriving_mps = _CREEP_MPS + law.approach_speed_mps(descent.way_left_m, self._base)
        speed_mps = min(descent.pull * self._base.max_speed_mps, arriving_mps)
        return law.drive((math.cos(off), math.sin(off)), speed_mps, self._base)

    def _off(self, pose: Pose2D, target: Pose2D) -> float:
        """How far it has to turn, 0 where any heading will do."""
        return abs(turned(target.theta, pose.theta)) if self.goal.heading_tolerance < math.pi else 0.0

    def _progress(
        self, now: Now, state: State, way_left_m: float, reason: Reason | None = None, note: str = ""
    ) -> Progress:
        gap_m = self._surroundings.guard.gap((now.here.x_m, now.here.y_m, now.here.theta))
        return Progress(self.goal.id, state, way_left_m, gap_m, reason, note)


def _apart_m(a: Pose2D, b: Pose2D) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
