# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The control law keeps the base's limits, and brings a base that takes its time to its goals without circling them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.config import BaseConfig, KhatibConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.khatib import descend
from edgefusion.navigation.law import approach_speed_mps, as_carried, drive, is_there, turn
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.types import Goal, Pose2D, Twist2D

BASE, KHATIB = BaseConfig(), KhatibConfig()
NOTHING, STILL = np.empty((0, 2)), Twist2D()
CYCLE_NS = 50_000_000
ANGLES = st.floats(-math.pi, math.pi)
POSES = st.builds(Pose2D, st.floats(-4, 4), st.floats(-4, 4), ANGLES)
TWISTS = st.builds(Twist2D, st.floats(-0.5, 0.5), st.floats(-1, 1))


def towards(angle: float, length: float = 1.0) -> tuple[float, float]:
    return length * math.cos(angle), length * math.sin(angle)


def test_what_lies_straight_ahead_is_driven_to_straight() -> None:
    assert drive((1, 0), 0.3, BASE) == Twist2D(0.3, 0.0)


@given(ANGLES, st.floats(0.001, 10), st.floats(0.001, 10))
def test_it_turns_to_the_side_where_the_direction_points_and_keeps_the_limits(
    angle: float, length: float, speed_mps: float
) -> None:
    twist = drive(towards(angle, length), speed_mps, BASE)
    assert twist.w_radps * angle >= 0
    assert abs(twist.w_radps) <= BASE.max_yaw_rate_radps
    assert 0 <= twist.v_mps <= min(speed_mps, BASE.max_speed_mps)


@given(st.floats(math.pi / 2 + 1e-6, math.pi), st.sampled_from([-1, 1]))
def test_what_lies_behind_is_turned_to_first(angle: float, side: int) -> None:
    twist = drive(towards(side * angle), 0.5, BASE)
    assert twist.v_mps == 0
    assert twist.w_radps == pytest.approx(side * BASE.max_yaw_rate_radps)


@given(ANGLES, st.floats(0.01, 100))
def test_only_the_direction_counts_not_the_length_of_the_vector(angle: float, length: float) -> None:
    one, other = drive(towards(angle), 0.3, BASE), drive(towards(angle, length), 0.3, BASE)
    assert (one.v_mps, one.w_radps) == pytest.approx((other.v_mps, other.w_radps))


def test_no_direction_and_no_speed_stand_still() -> None:
    assert drive((0, 0), 0.3, BASE) == drive((0, 1), 0, BASE) == STILL


@pytest.mark.parametrize("bad", [((math.nan, 0), 0.1), ((1, math.inf), 0.1), ((1, 0), -0.1), ((1, 0), math.nan)])
def test_what_is_no_direction_or_speed_is_refused(bad: tuple) -> None:
    with pytest.raises(RefusedError, match="drive: expected a finite direction and speed, got "):
        drive(*bad, BASE)


@given(st.floats(-2, 2), st.floats(-5, 5))
def test_what_is_carried_is_whole_never_faster_and_carried_as_it_is(v_mps: float, w_radps: float) -> None:
    twist = Twist2D(v_mps, w_radps)
    carried = as_carried(twist)
    for kept, asked in ((carried.v_mps * 1000, v_mps * 1000), map(math.degrees, (carried.w_radps, w_radps))):
        assert kept == pytest.approx(round(kept), abs=1e-9)
        assert abs(kept) <= abs(asked) + 2e-6
        assert abs(kept - asked) < 1
        assert kept * asked >= 0
    assert as_carried(carried) == carried


@pytest.mark.parametrize("degrees", range(-360, 361, 7))
def test_whole_degrees_and_millimetres_are_carried_whole(degrees: int) -> None:
    twist = Twist2D(degrees / 1000, math.radians(degrees))
    assert as_carried(twist) == twist


@given(st.floats(0, 20), st.floats(0.05, 4))
def test_the_approach_can_always_be_stopped_where_the_way_ends(way_left_m: float, braking_mps2: float) -> None:
    base = BaseConfig(acceleration_mps2=braking_mps2)
    speed_mps = approach_speed_mps(way_left_m, base)
    assert speed_mps * 0.1 + speed_mps**2 / (2 * braking_mps2) == pytest.approx(way_left_m)
    assert speed_mps <= math.sqrt(2 * braking_mps2 * way_left_m)


@given(st.floats(1e-3, math.pi), st.sampled_from([-1, 1]))
def test_a_turn_on_the_spot_is_never_lost_on_the_wire(angle: float, side: int) -> None:
    twist = turn(side * angle, BASE)
    carried = as_carried(twist)
    assert carried.v_mps == 0
    assert math.radians(1) - 1e-9 <= side * carried.w_radps <= BASE.max_yaw_rate_radps + 1e-9
    assert turn(0.0, BASE) == STILL


def test_a_base_that_can_hardly_turn_is_not_turned_faster_than_it_may() -> None:
    assert turn(1.0, BaseConfig(max_yaw_rate_radps=0.01)) == Twist2D(0.0, 0.01)


@pytest.mark.parametrize("angle", [0.1, -1.0, 3.0])
def test_a_base_that_turns_sluggishly_does_not_turn_past_where_it_shall(angle: float) -> None:
    run = Run(BaseConfig(yaw_acceleration_radps2=0.2), STILL)
    assert_reached(run, Goal("g", Pose2D(theta=angle)))
    assert run.turned <= abs(angle) + math.radians(1)


def test_a_place_is_reached_within_the_tolerance_and_not_left_again_before_its_end() -> None:
    goal = Goal("g", Pose2D(), position_tolerance_m=0.05)
    assert [is_there(d, False, goal) for d in (0.029, 0.031, 0.05)] == [True, False, False]
    assert [is_there(d, True, goal) for d in (0.031, 0.05, 0.051)] == [True, True, False]


class Run:
    """A base that drives to a goal on free ground by the law, its commands late by the delay."""

    def __init__(self, base: BaseConfig, start: Twist2D) -> None:
        spec = BaseSpec(acceleration_mps2=base.acceleration_mps2, yaw_acceleration_radps2=base.yaw_acceleration_radps2)
        self.base, self.robot = base, SimBase(spec)
        self.robot.command(start)
        self.robot.step(3_000_000_000)
        self.there, self.turned, self.way_m, self.seconds = False, 0.0, 0.0, 0.0

    def to(self, goal: Goal) -> Pose2D:
        """Drives until it rests there; returns where the goal is then, seen from it."""
        delayed = [self.robot.twist] * round(self.base.command_delay_s * 1e9 / CYCLE_NS)
        off = goal.pose.relative_to(self.robot.odometry)
        for self.seconds in (i * CYCLE_NS / 1e9 for i in range(2400)):
            off = goal.pose.relative_to(self.robot.odometry)
            command = self.command(off, goal)
            if command == self.robot.twist == STILL:
                break
            self.drive([*delayed, as_carried(command)][0])
            delayed = [*delayed, as_carried(command)][1:]
        return off

    def command(self, off: Pose2D, goal: Goal) -> Twist2D:
        distance_m = math.hypot(off.x_m, off.y_m)
        self.there = is_there(distance_m, self.there, goal)
        if self.there:
            return turn(off.theta, self.base) if abs(off.theta) > goal.heading_tolerance else STILL
        u_mps = descend((off.x_m, off.y_m), NOTHING, False, KHATIB).u_mps
        speed_mps = min(math.hypot(*u_mps), approach_speed_mps(distance_m, self.base))
        return drive(u_mps, speed_mps, self.base)

    def drive(self, command: Twist2D) -> None:
        before = self.robot.odometry
        self.robot.command(command)
        self.robot.step(CYCLE_NS)
        step = self.robot.odometry.relative_to(before)
        self.turned += abs(step.theta)
        self.way_m += math.hypot(step.x_m, step.y_m)


def assert_reached(run: Run, goal: Goal) -> None:
    off = run.to(goal)
    assert run.robot.twist == STILL
    assert math.hypot(off.x_m, off.y_m) <= goal.position_tolerance_m
    assert abs(off.theta) <= goal.heading_tolerance


@settings(max_examples=30)
@given(POSES, st.sampled_from([0.05, 0.1, 0.2]), st.floats(0.2, 2.0))
def test_every_goal_on_free_ground_is_reached_without_a_detour_or_a_circle(
    pose: Pose2D, delay_s: float, acceleration_mps2: float
) -> None:
    run = Run(BaseConfig(command_delay_s=delay_s, acceleration_mps2=acceleration_mps2), STILL)
    assert_reached(run, Goal("g", pose))
    distance_m, bearing = math.hypot(pose.x_m, pose.y_m), math.atan2(pose.y_m, pose.x_m)
    assert run.way_m <= 1.1 * distance_m + 0.1
    assert run.turned <= abs(bearing) + abs(math.remainder(pose.theta - bearing, 2 * math.pi)) + 2.0


@settings(max_examples=15)
@given(POSES, TWISTS)
def test_a_goal_that_is_given_at_speed_is_reached_too(pose: Pose2D, start: Twist2D) -> None:
    assert_reached(Run(BASE, start), Goal("g", pose))


@pytest.mark.parametrize("place", [(-1, 0), (0, 0.2), (0.06, 0), (0, -0.06), (5, 5.5)])
def test_goals_behind_beside_and_close_are_reached_within_tight_tolerances(place: tuple[float, float]) -> None:
    assert_reached(Run(BASE, STILL), Goal("g", Pose2D(*place, math.radians(15)), 0.01, math.radians(0.5)))
