# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Out of where the field's way is too narrow to be simply followed: searched with the hull, driven leg by leg."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

from edgefusion._core import Manoeuvre
from edgefusion.config import BaseConfig
from edgefusion.navigation import law
from edgefusion.navigation.drive_model import turned
from edgefusion.navigation.function_field import FunctionField
from edgefusion.navigation.patience import Stall
from edgefusion.navigation.steering import Steering
from edgefusion.navigation.surroundings import Surroundings, row
from edgefusion.types import Goal, Pose2D, Twist2D

Leg = Tuple[float, float, Tuple[float, float, float]]

POSES_A_STEP = 120
"""Tried while the robot stands; a search that finds nothing takes some seconds."""

GAIN_M = 1.0
"""A manoeuvre leads so much nearer to the goal."""

PLANNED = 0.7
"""Of the margin is kept where a manoeuvre is planned; driven, it may come a little nearer (steering.CLOSE)."""

AVOIDED_M, UNFIT_WITHIN_M = 0.25, 2.0
"""Where no manoeuvre is found, ways through a circle about the first place that is too narrow become longer."""

SPEED_MPS = 0.15

_DONE_M, _DONE = 0.01, math.radians(3)
_SIDEWAYS_GAIN, _HEADING_GAIN = 4.0, 2.0


class Manoeuvring:
    """Idle, searching, or driving what was found. to_goal: whether that leads to the goal's own pose."""

    def __init__(self, surroundings: Surroundings, field: FunctionField, base: BaseConfig, margin_m: float) -> None:
        self._surroundings, self._field, self._base = surroundings, field, base
        self._margin_m = margin_m
        self._search = Manoeuvre(surroundings.footprint)
        self._legs: list[Leg] = []
        self._stall = Stall()
        self._begun: Pose2D | None = None  # where the one under way began
        self.to_goal = False

    @property
    def active(self) -> bool:
        return self._search.running or self.driving

    @property
    def driving(self) -> bool:
        return bool(self._legs)

    def begin(self, pose: Pose2D, goal: Goal, target: Pose2D, turning: bool) -> None:
        """Looks for a way from here: down the field, or, turning or close to the goal, to the goal's pose."""
        left_m = self._field.left_m(pose)
        if not (turning or math.isfinite(left_m)):
            return  # no way leads from here: nothing says where to
        others = self._surroundings.rear_m
        common = (self._surroundings.map, self._field.function, row(pose), PLANNED * self._margin_m, others)
        self.to_goal = turning or left_m < GAIN_M
        if self.to_goal:
            heading_tolerance = max(goal.heading_tolerance, _DONE + math.radians(3.75))  # half a step of the search
            self._search.begin(
                *common,
                pose=row(target),
                position_tolerance_m=0.6 * goal.position_tolerance_m,
                heading_tolerance=heading_tolerance,
            )
        else:
            self._search.begin(*common, value_m=left_m - GAIN_M)

    def step(self, stamp_ns: int, pose: Pose2D, steering: Steering) -> Twist2D | None:
        """The velocity for a robot there; None when it is over, for better or worse."""
        if self._search.running:
            self._look(pose)
            return Twist2D()
        wish = self._wish(pose)
        if wish is None:
            if self._begun is not None and _near(self._begun, pose):  # it leads to where the robot is
                self._give_up(pose)
            return None
        if self._stall.lasts(stamp_ns, pose):  # something is in the way after all
            self._legs, self.to_goal = [], False
            return None
        return steering.along(wish)

    def _look(self, pose: Pose2D) -> None:
        """Goes on searching; where that finds nothing, the place is avoided from now on."""
        if not self._search.advance(self._surroundings.map, self._field.function, POSES_A_STEP):
            return
        self._legs, self._stall, self._begun = self._search.legs, Stall(), pose
        if not self._legs:
            self._give_up(pose)

    def _give_up(self, pose: Pose2D) -> None:
        self._legs, self.to_goal = [], False
        self._surroundings.map.avoid(*self._first_unfit(pose), AVOIDED_M)

    def _wish(self, pose: Pose2D) -> Twist2D | None:
        """The velocity on the present leg; None when the last is done."""
        while self._legs and _is_done(self._legs[0], pose):
            self._legs.pop(0)
        if not self._legs:
            return None
        way_m, turn, end = self._legs[0]
        if way_m == 0:
            return law.turn(turned(end[2], pose.theta), self._base)
        return self._along(way_m, turn, Pose2D(*end), pose)

    def _along(self, way_m: float, turn: float, end: Pose2D, pose: Pose2D) -> Twist2D:
        sign, curvature = math.copysign(1, way_m), turn / way_m
        left = abs(turned(end.theta, pose.theta) / curvature) if turn else math.hypot(*_apart(end, pose))
        v_mps = sign * min(SPEED_MPS, self._base.max_speed_mps, 0.03 + law.approach_speed_mps(left, self._base))
        if turn:
            return Twist2D(v_mps, v_mps * curvature)
        off = pose.relative_to(end)
        return Twist2D(v_mps, -_HEADING_GAIN * off.theta - sign * _SIDEWAYS_GAIN * off.y_m)

    def _first_unfit(self, pose: Pose2D) -> Tuple[float, float]:
        """Where on the way ahead the hull does not fit, looking along it; else a little ahead."""
        way = self._field.way(pose, UNFIT_WITHIN_M)
        for (x, y), (dx, dy) in zip(way[1:], np.diff(way, axis=0)):
            if not self._surroundings.guard.fits((x, y, math.atan2(dy, dx)), PLANNED * self._margin_m):
                return float(x), float(y)
        ahead = way[: len(way) // 4 + 1]
        return (float(ahead[-1][0]), float(ahead[-1][1])) if len(ahead) else (pose.x_m, pose.y_m)


def _is_done(leg: Leg, pose: Pose2D) -> bool:
    way_m, turn, end = leg
    left = turned(end[2], pose.theta)
    if way_m == 0:
        return abs(left) < _DONE
    if turn:  # an arc ends where it has turned far enough
        return left * math.copysign(1, turn) < _DONE
    return pose.relative_to(Pose2D(*end)).x_m * math.copysign(1, way_m) > -_DONE_M


def _near(a: Pose2D, b: Pose2D) -> bool:
    return math.hypot(*_apart(a, b)) < _DONE_M and abs(turned(a.theta, b.theta)) < _DONE


def _apart(a: Pose2D, b: Pose2D) -> Tuple[float, float]:
    return a.x_m - b.x_m, a.y_m - b.y_m
