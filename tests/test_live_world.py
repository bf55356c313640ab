# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A live world's robot stops at walls and says so; its laser and sonars see what is there."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.config.navigation import P3DX_FOOTPRINT_M
from edgefusion.sim.hull import bounded
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.live_body import LiveBody
from edgefusion.sim.live_world import LiveWorld
from edgefusion.sim.robot import BaseSpec
from edgefusion.sim.world_file import load_world
from edgefusion.types import Pose2D, Twist2D

S = 1_000_000_000
WALLS = bounded(np.array([[1.0, -5.0, 1.0, 5.0], [-1.0, -5.0, -1.0, 5.0]]))
UNTOUCHED = ((False,) * 5, (False,) * 5)


def body(pose: Pose2D = Pose2D(), now_ns: int = 7 * S) -> LiveBody:  # noqa: B008
    return LiveBody(BaseSpec(), pose, WALLS, P3DX_FOOTPRINT_M, now_ns)


def after(robot: LiveBody, twist: Twist2D, seconds: float) -> LiveBody:
    robot.command(twist)
    robot.step_to(robot.stamp_ns + round(seconds * S))
    return robot


def test_it_drives_as_far_as_it_is_told_where_nothing_is_in_the_way() -> None:
    robot = after(body(), Twist2D(0.2, 0.0), 2.0)
    assert robot.odometry.x_m == pytest.approx(0.2 * 2 - 0.2**2 / 2 / 0.3, abs=1e-6)
    assert robot.stalled == (False, False) and robot.bumpers == UNTOUCHED


@pytest.mark.parametrize(
    ("start", "v_mps", "rest_m", "front", "number"),
    [
        (Pose2D(), 0.5, 1.0 - 0.210, True, None),
        (Pose2D(), -0.5, -1.0 + 0.301, False, None),
        (Pose2D(0, 0, math.radians(20)), 0.4, None, True, 3),
        (Pose2D(0, 0, math.radians(-20)), 0.4, None, True, 1),
    ],
)
def test_a_wall_stalls_it_and_the_bumper_that_touches_feels_it(start, v_mps, rest_m, front, number) -> None:
    robot = after(body(start), Twist2D(v_mps, 0.0), 8.0)
    assert robot.stalled == (True, True) and robot.twist.v_mps == pytest.approx(0.0, abs=0.01)
    if rest_m is not None:
        assert robot.pose.x_m == pytest.approx(rest_m, abs=0.01) and robot.odometry.x_m == pytest.approx(
            rest_m, abs=0.01
        )
    pressed, other = robot.bumpers if front else robot.bumpers[::-1]
    assert sum(pressed) == 1 and not any(other)
    assert number is None or pressed[number]


def test_it_gets_away_from_a_wall_by_itself() -> None:
    robot = after(body(), Twist2D(0.5, 0.0), 6.0)
    after(robot, Twist2D(-0.2, 0.0), 2.0)
    assert robot.stalled == (False, False) and robot.bumpers == UNTOUCHED and robot.pose.x_m < 0.6


def test_a_tail_that_swings_into_a_wall_stalls_it() -> None:
    robot = after(body(Pose2D(-1.0 + 0.25, 0.0, math.pi / 2)), Twist2D(0.0, 0.5), 5.0)
    assert robot.stalled == (True, True) and robot.pose.theta < math.pi / 2 + 0.3
    assert sum(robot.bumpers[0]) + sum(robot.bumpers[1]) == 1


def test_halting_needs_no_ramp() -> None:
    robot = after(body(), Twist2D(0.4, 0.0), 1.0)
    robot.halt()
    assert robot.twist == Twist2D()


@pytest.mark.parametrize(("number", "range_m"), [(3, 1.0 - 0.166), (4, 1.0 - 0.166), (11, 1.0 - 0.255), (0, 4.48)])
def test_sonars_hear_the_nearest_wall_within_their_cone(number: int, range_m: float) -> None:
    assert body().sonar_m(number) == pytest.approx(range_m, abs=0.02)


def test_in_a_world_that_ships_the_laser_sees_what_the_robot_stands_before() -> None:
    world = LiveWorld(load_world("laboratory"), 0)
    world.step_to(2 * S)
    clean = LaserSpec(sigma_m=0.0, dropped=0.0, mixed=0.0)
    first = world.scan_at(S, clean)
    assert np.isfinite(first.ranges_m).mean() > 0.5 and (first.ranges_m > 0.2).all()
    np.testing.assert_array_equal(first.ranges_m, world.scan_at(int(1.5 * S), clean).ranges_m)  # it stands
    world.body.command(Twist2D(0.3, 0.0))
    world.step_to(4 * S)
    assert (world.scan_at(int(3.9 * S), clean).ranges_m != first.ranges_m).any()
