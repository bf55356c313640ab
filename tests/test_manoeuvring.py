# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A manoeuvre, from the search to its end: driven, or given up so that the place is avoided from then on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.navigation.function_field import FunctionField
from edgefusion.navigation.manoeuvring import GAIN_M, Manoeuvring
from edgefusion.navigation.steering import Steering
from edgefusion.navigation.surroundings import Surroundings, row
from edgefusion.types import Goal, Pose2D, Twist2D
from navigation_scenes import box, put, see, wall
from navigator_drives import BASE, HERE, NAVIGATION, S

GOAL = Goal("goal", Pose2D(2.5, 0.0))
TICK_NS = S // 20
LIMIT = 400
"""Steps: a search that finds nothing takes some seconds."""


class Bench:
    """A robot that sees the ground about it and these points, and goes exactly where it is told to."""

    def __init__(self, points=()):
        self.around = Surroundings(NAVIGATION, BASE)
        self.around.stand(0, HERE, GOAL.pose)
        see(self.around.map, radius_m=4.0)
        put(self.around.map, points)
        self.field = FunctionField(NAVIGATION, self.around.footprint.inscribed_m)
        self.pose, self.stamp_ns = HERE, 0
        self.manoeuvring = Manoeuvring(self.around, self.field, BASE, NAVIGATION.margin_m)
        self.left_m = self.look_again()
        self.manoeuvring.begin(self.pose, GOAL, GOAL.pose, turning=False)

    def look_again(self):
        """The way to the goal from the start, as it is by now."""
        self.field.update(self.around, GOAL.pose, GOAL.position_tolerance_m, HERE)
        while self.field.function.running:
            self.field.update(self.around, GOAL.pose, GOAL.position_tolerance_m, HERE)
        return self.field.left_m(HERE)

    def step(self):
        """The answer to one step; the robot is where that led to."""
        self.around.look(self.stamp_ns, (*row(self.pose), 0.0, 0.0), self.pose, self.around.rear_m)
        steering = Steering(self.around, NAVIGATION.margin_m, (*row(self.pose), 0.0, 0.0), 0.1)
        twist = self.manoeuvring.step(self.stamp_ns, self.pose, steering)
        self.pose = self.pose.compose((twist or Twist2D()).motion(TICK_NS / S))
        self.stamp_ns += TICK_NS
        return twist

    def until_over(self):
        """The velocities until then."""
        answers = []
        while self.manoeuvring.active:
            answers.append(self.step())
            assert len(answers) < LIMIT
        return [twist for twist in answers if twist is not None]


def test_one_that_leads_nearer_to_the_goal_is_driven_and_nothing_is_avoided():
    bench = Bench()
    twists = bench.until_over()
    assert twists[0] == Twist2D()  # it stands while it searches
    assert GAIN_M - 0.1 < bench.pose.x_m < GAIN_M + 0.2
    assert bench.look_again() == pytest.approx(bench.left_m, abs=1e-6)


def test_one_that_leads_to_where_the_robot_stands_is_given_up():
    """It has been moved there while it was searching: only another way makes a difference then."""
    there = Bench()
    there.until_over()
    bench = Bench()
    bench.pose = there.pose
    assert set(bench.until_over()) <= {Twist2D()}
    assert not bench.manoeuvring.active
    assert bench.look_again() > bench.left_m + 0.05


def test_one_that_is_not_found_is_given_up_after_a_while():
    """The field's way leads out of a chamber by a gap that the hull is too wide for."""
    corners = [(0.6, 0.2), (0.6, 0.6), (-0.6, 0.6), (-0.6, -0.6), (0.6, -0.6), (0.6, -0.2)]
    bench = Bench(np.concatenate([wall(*ends) for ends in zip(corners, corners[1:])]))
    assert math.isfinite(bench.left_m)
    assert set(bench.until_over()) == {Twist2D()}
    assert bench.pose == HERE
    assert bench.look_again() > bench.left_m + 0.05


def test_where_no_way_leads_nothing_is_searched():
    bench = Bench(box(2.1, -0.4, 2.9, 0.4))
    assert bench.left_m == math.inf
    assert not bench.manoeuvring.active
