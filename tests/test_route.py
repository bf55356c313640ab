# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The route follower arrives from anywhere, within its limits, and stays."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from edgefusion.sim.route import PASSED_M, RouteFollower, RouteLimits
from edgefusion.types import Pose2D, Twist2D

STEP_S = 0.05
LIMITS = RouteLimits()
POSES = st.builds(Pose2D, st.floats(-4, 4), st.floats(-4, 4), st.floats(-math.pi, math.pi))
POINTS = st.tuples(st.floats(-4, 4), st.floats(-4, 4))


def drive(follower: RouteFollower, pose: Pose2D, steps: int = 4000) -> list[tuple[Pose2D, Twist2D]]:
    """Poses and the velocities that they were answered with, for a base that needs time to change its speed."""
    trail, twist = [], Twist2D()
    for _ in range(steps):
        asked = follower.step(pose)
        trail.append((pose, asked))
        if follower.arrived:
            break
        twist = Twist2D(
            twist.v_mps + max(-0.3 * STEP_S, min(0.3 * STEP_S, asked.v_mps - twist.v_mps)),
            twist.w_radps + max(-1.7 * STEP_S, min(1.7 * STEP_S, asked.w_radps - twist.w_radps)),
        )
        pose = pose.compose(twist.motion(STEP_S))
    return trail


def apart(pose: Pose2D, goal: Pose2D) -> tuple[float, float]:
    off = pose.relative_to(goal)
    return math.hypot(off.x_m, off.y_m), abs(off.theta)


@settings(max_examples=60)
@example(start=Pose2D(2, 0, 0), route=[(0.0, 0.0), (0.5, 0.0)], goal=Pose2D())  # it comes to the goal at full speed
@given(start=POSES, route=st.lists(POINTS, max_size=3), goal=POSES)
def test_it_arrives_at_the_pose_from_anywhere(start: Pose2D, route, goal: Pose2D) -> None:
    follower = RouteFollower(route, goal)
    place_m, direction = apart(drive(follower, start)[-1][0], goal)
    assert follower.arrived
    assert place_m < 0.05 and direction < 2 * LIMITS.direction


@settings(max_examples=60)
@given(start=POSES, route=st.lists(POINTS, max_size=3), goal=POSES)
def test_it_never_asks_for_more_than_its_limits_nor_drives_backwards(start: Pose2D, route, goal: Pose2D) -> None:
    for _, twist in drive(RouteFollower(route, goal), start):
        assert 0 <= twist.v_mps <= LIMITS.speed_mps
        assert abs(twist.w_radps) <= LIMITS.yaw_rate_radps


def test_it_passes_every_point_of_the_route_in_order() -> None:
    route = [(2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]
    trail = drive(RouteFollower(route, Pose2D(0, 1, 0)), Pose2D())
    first = [
        next(i for i, (pose, _) in enumerate(trail) if math.hypot(pose.x_m - x, pose.y_m - y) < PASSED_M)
        for x, y in route
    ]
    assert first == sorted(first)


def test_it_drives_straight_ahead_at_full_speed_and_turns_on_the_spot_to_what_is_behind() -> None:
    assert RouteFollower([], Pose2D(5, 0)).step(Pose2D()) == Twist2D(LIMITS.speed_mps, 0)
    behind = RouteFollower([], Pose2D(-5, 1)).step(Pose2D())
    assert behind == Twist2D(0, LIMITS.yaw_rate_radps)


@pytest.mark.parametrize("pose", [Pose2D(1, 2, 0.5), Pose2D(1.2, 2, 0.5)], ids=["there", "pushed away"])
def test_once_arrived_it_stands_still(pose: Pose2D) -> None:
    goal = Pose2D(1, 2, 0.5)
    follower = RouteFollower([], goal)
    assert follower.step(goal) == Twist2D()
    assert follower.arrived
    assert follower.step(pose) == Twist2D()
