# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated P3-DX keeps its limits, arrives where geometry says, and errs only as it is told to, by its seed."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.types import STILL, Pose2D, Twist2D

SPEC = BaseSpec()
STEP_NS = 10_000_000
S = 1_000_000_000
QUICK = replace(SPEC, acceleration_mps2=1e9, yaw_acceleration_radps2=1e9)
"""Reaches any speed at once."""
SLIPPING = replace(SPEC, slip_m=0.01)

COMMANDS = st.lists(st.builds(Twist2D, st.floats(-3, 3), st.floats(-6, 6)), min_size=1, max_size=10)


def drive(base: SimBase, twist: Twist2D, duration_ns: int, step_ns: int = STEP_NS) -> SimBase:
    base.command(twist)
    for _ in range(duration_ns // step_ns):
        base.step(step_ns)
    return base


def assert_near(a: Pose2D, b: Pose2D, tolerance: float = 1e-9) -> None:
    off = a.relative_to(b)
    assert (off.x_m, off.y_m, off.theta) == pytest.approx((0, 0, 0), abs=tolerance)


@settings(max_examples=30)
@given(COMMANDS)
def test_speeds_and_accelerations_keep_within_the_limits_whatever_is_commanded(commands: list[Twist2D]) -> None:
    base, before = SimBase(), Twist2D()
    for command in commands:
        base.command(command)
        for _ in range(20):
            base.step(STEP_NS)
            assert abs(base.twist.v_mps) <= SPEC.max_speed_mps
            assert abs(base.twist.w_radps) <= SPEC.max_yaw_rate_radps
            assert abs(base.twist.v_mps - before.v_mps) <= SPEC.acceleration_mps2 * 0.01 + 1e-12
            assert abs(base.twist.w_radps - before.w_radps) <= SPEC.yaw_acceleration_radps2 * 0.01 + 1e-12
            before = base.twist


def test_it_gets_as_fast_as_its_limits_but_not_faster() -> None:
    assert drive(SimBase(), Twist2D(9, -9), 5 * S).twist == Twist2D(SPEC.max_speed_mps, -SPEC.max_yaw_rate_radps)


@pytest.mark.parametrize(
    ("asked", "driven"),
    [
        (Twist2D(0.1234, 0), Twist2D(0.123, 0)),
        (Twist2D(-0.1236, 0), Twist2D(-0.124, 0)),
        (Twist2D(0.0004, math.radians(0.4)), Twist2D(0, 0)),
        (Twist2D(0, math.radians(17.3)), Twist2D(0, math.radians(17))),
        (Twist2D(0, math.radians(-17.6)), Twist2D(0, math.radians(-18))),
    ],
)
def test_commands_are_whole_millimetres_and_degrees_a_second(asked: Twist2D, driven: Twist2D) -> None:
    assert drive(SimBase(), asked, 2 * S).twist == driven


def test_speeding_up_and_braking_take_the_way_that_physics_says() -> None:
    base = drive(SimBase(), Twist2D(0.3, 0), 3 * S)
    assert base.pose.x_m == pytest.approx(0.3 * 1 / 2 + 0.3 * 2)
    drive(base, Twist2D(), 2 * S)
    assert base.pose.x_m == pytest.approx(0.3 * 1 / 2 + 0.3 * 2 + 0.3 * 1 / 2)
    assert base.twist == Twist2D()


def test_a_circle_closes() -> None:
    turn = Twist2D(0.5, math.radians(36))
    base = drive(SimBase(QUICK), turn, 5 * S)
    assert_near(base.pose, Pose2D(0, 2 * 0.5 / math.radians(36), math.pi))
    assert_near(drive(base, turn, 5 * S).pose, STILL)


@pytest.mark.parametrize("step_ns", [1_000_000, 50_000_000, S, 6 * S])
def test_at_constant_speed_the_step_does_not_matter(step_ns: int) -> None:
    driven = drive(SimBase(QUICK), Twist2D(0.7, math.radians(25)), 6 * S, step_ns)
    assert_near(driven.pose, Twist2D(0.7, math.radians(25)).motion(6))


@pytest.mark.parametrize("step_ns", [1_000_000, 70_000_000, 3 * S])
def test_straight_on_the_step_does_not_matter_while_it_speeds_up_either(step_ns: int) -> None:
    base = drive(SimBase(), Twist2D(0.5, 0), 21 * S, step_ns)
    assert base.pose.x_m == pytest.approx(0.5 * 21 - 0.5**2 / 0.3 / 2, abs=1e-9)


def wander(base: SimBase) -> SimBase:
    for v, degps in ((0.5, 0), (0.4, 30), (0.0, -60), (-0.3, 10), (0.8, -20)):
        drive(base, Twist2D(v, math.radians(degps)), 4 * S)
    return base


def test_without_slip_and_drift_odometry_is_the_truth() -> None:
    base = wander(SimBase())
    assert base.odometry == base.pose
    start = Pose2D(3, -2, 1)
    assert_near(start.compose(base.odometry), wander(SimBase(pose=start)).pose)


def test_with_slip_odometry_drifts_from_the_truth_and_the_same_seed_drifts_alike() -> None:
    base, again, other = (wander(SimBase(SLIPPING, seed=seed)) for seed in (4, 4, 5))
    off = base.pose.relative_to(base.odometry)
    assert math.hypot(off.x_m, off.y_m) > 0.005
    assert base.pose == again.pose != other.pose
    assert base.odometry == again.odometry == other.odometry == wander(SimBase()).odometry


@pytest.mark.parametrize("step_ns", [5_000_000, 200_000_000])
def test_wheels_slip_by_the_root_of_the_way_in_steps_of_any_length(step_ns: int) -> None:
    spec = replace(QUICK, slip_m=0.01)
    ways_m = [drive(SimBase(spec, seed=i), Twist2D(1, 0), 4 * S, step_ns).pose.theta for i in range(60)]
    deviation = math.sqrt(sum(way_m**2 for way_m in ways_m) / len(ways_m))
    expected = 0.01 * math.sqrt(4) * math.sqrt(2) / SPEC.wheel_base_m
    assert deviation == pytest.approx(expected, rel=0.3)


def test_a_robot_that_stands_does_not_slip() -> None:
    assert drive(SimBase(SLIPPING, seed=1), Twist2D(), 5 * S).pose == STILL


def test_a_wheel_that_goes_farther_than_counted_bends_the_way() -> None:
    spec = replace(QUICK, right_drift_percent=1.0)
    base = drive(SimBase(spec), Twist2D(1, 0), 10 * S)
    assert base.odometry.x_m == pytest.approx(10) and base.odometry.theta == 0
    assert base.pose.theta == pytest.approx(10 * 0.01 / SPEC.wheel_base_m)
    both = replace(QUICK, left_drift_percent=-2.0, right_drift_percent=-2.0)
    assert_near(drive(SimBase(both), Twist2D(1, 0), 10 * S).pose, Pose2D(9.8, 0, 0))


def test_sensors_may_ask_where_it_was_within_the_last_second() -> None:
    base = drive(SimBase(QUICK, stamp_ns=7 * S), Twist2D(1, 0), 3 * S)
    assert base.stamp_ns == 10 * S
    assert base.pose_at(base.stamp_ns) == base.pose
    assert base.pose_at(10 * S - 123_456_789).x_m == pytest.approx(3 - 0.123456789)
    for outside_ns in (10 * S + 1, 9 * S - 1):
        with pytest.raises(RefusedError, match=rf"^stamp_ns: the poses cover {9 * S} to {10 * S}, got {outside_ns}$"):
            base.pose_at(outside_ns)


@pytest.mark.parametrize("dt_ns", [0, -1])
def test_a_step_takes_time(dt_ns: int) -> None:
    with pytest.raises(RefusedError, match=f"^dt_ns: expected more than 0, got {dt_ns}$"):
        SimBase().step(dt_ns)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"max_speed_mps": 0}, "max_speed_mps: expected a finite number above 0, got 0"),
        ({"acceleration_mps2": math.inf}, "acceleration_mps2: expected a finite number above 0, got inf"),
        ({"wheel_base_m": -1}, "wheel_base_m: expected a finite number above 0, got -1"),
        ({"slip_m": -0.1}, "slip_m: expected a finite number of at least 0, got -0.1"),
        ({"left_drift_percent": math.nan}, "left_drift_percent: expected a finite number above -100, got nan"),
        ({"right_drift_percent": -100}, "right_drift_percent: expected a finite number above -100, got -100"),
    ],
)
def test_what_is_no_base_is_refused_by_name(changed: dict, message: str) -> None:
    with pytest.raises(RefusedError, match=f"^{message}$"):
        replace(SPEC, **changed)
