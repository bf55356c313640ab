# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The frame in which the robot never jumps: odom until the odometry jumps, and without a seam there."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.config import BaseConfig
from edgefusion.navigation.local_frame import LocalFrame
from edgefusion.types import STILL, Pose2D, Twist2D

BASE = BaseConfig()
CYCLE_S = 0.05
COORDINATES, ANGLES = st.floats(-20, 20), st.floats(-3.1, 3.1)
JUMPS = st.builds(Pose2D, COORDINATES, COORDINATES, ANGLES).filter(lambda p: math.hypot(p.x_m, p.y_m) > 0.2)
TWISTS = st.builds(Twist2D, st.floats(-0.5, 0.5), st.floats(-1, 1))


def driven(frame, twist, steps, start=STILL, after=lambda odometry: odometry):
    """Poses of the frame while the robot drives evenly; its odometry comes out of `after`."""
    odometry, poses = start, []
    for _ in range(steps):
        odometry = odometry.compose(twist.motion(CYCLE_S))
        poses.append(frame.enter(after(odometry), CYCLE_S, twist))
    return odometry, poses


def as_rows(poses):
    return np.array([(pose.x_m, pose.y_m, math.cos(pose.theta), math.sin(pose.theta)) for pose in poses])


@given(TWISTS)
def test_until_a_jump_it_is_odom(twist):
    frame, start = LocalFrame(BASE), Pose2D(3.0, -2.0, 1.0)
    assert frame.enter(start, 0.0, Twist2D()) == start
    odometry, poses = driven(frame, twist, 10, start)
    assert as_rows(poses[-1:]) == pytest.approx(as_rows([odometry]))
    assert frame.place(Pose2D(1.0, 2.0, 0.5)) == Pose2D(1.0, 2.0, 0.5)
    np.testing.assert_allclose(frame.in_odom(np.array([[1.0, 2.0]])), [[1.0, 2.0]])


@given(TWISTS, JUMPS)
def test_across_a_jump_the_robot_drives_on_evenly(twist, jump):
    smooth, jumping = LocalFrame(BASE), LocalFrame(BASE)
    for frame in (smooth, jumping):
        frame.enter(Pose2D(), 0.0, Twist2D())
    odometry, before = driven(jumping, twist, 5)
    _, after = driven(jumping, twist, 5, odometry, jump.compose)
    _, expected = driven(smooth, twist, 10)
    if jumping.place(Pose2D()) != Pose2D():  # a jump about its own place is none
        np.testing.assert_allclose(as_rows(before + after), as_rows(expected), atol=1e-6)


@given(JUMPS, st.builds(Pose2D, COORDINATES, COORDINATES, ANGLES))
def test_after_a_jump_a_goal_of_odom_is_where_the_new_odometry_puts_it(jump, goal):
    frame = LocalFrame(BASE)
    frame.enter(Pose2D(), 0.0, Twist2D())
    here = frame.enter(jump, CYCLE_S, Twist2D())
    assert here == Pose2D()
    assert as_rows([frame.place(goal).relative_to(here)]) == pytest.approx(as_rows([goal.relative_to(jump)]), abs=1e-6)


@given(JUMPS, st.lists(st.tuples(COORDINATES, COORDINATES), max_size=5))
def test_points_are_given_back_in_odom(jump, points):
    frame = LocalFrame(BASE)
    frame.enter(Pose2D(), 0.0, Twist2D())
    frame.enter(jump, CYCLE_S, Twist2D())
    in_odom = frame.in_odom(np.array(points, float).reshape(-1, 2))
    assert in_odom.shape == (len(points), 2)
    for (x, y), (ox, oy) in zip(points, in_odom):
        back = frame.place(Pose2D(ox, oy, 0.0))
        assert (back.x_m, back.y_m) == pytest.approx((x, y), abs=1e-6)


@pytest.mark.parametrize(
    ("odometry", "dt_s", "jumps"),
    [
        (Pose2D(0.12, 0.0, 0.0), 0.05, 0),  # twice the top speed and 8 cm
        (Pose2D(0.14, 0.0, 0.0), 0.05, 1),
        (Pose2D(0.0, -0.14, 0.0), 0.05, 1),
        (Pose2D(0.5, 0.0, 0.0), 1.0, 0),
        (Pose2D(1.2, 0.0, 0.0), 1.0, 1),
        (Pose2D(0.0, 0.0, math.radians(15)), 0.05, 0),  # twice the top rate and 10 degrees
        (Pose2D(0.0, 0.0, math.radians(-17)), 0.05, 1),
    ],
)
def test_what_the_base_can_do_is_no_jump(odometry, dt_s, jumps):
    frame = LocalFrame(BASE)
    frame.enter(Pose2D(), 0.0, Twist2D())
    frame.enter(odometry, dt_s, Twist2D())
    assert (frame.place(Pose2D()) != Pose2D()) == jumps


def test_two_jumps_add_up():
    frame = LocalFrame(BASE)
    frame.enter(Pose2D(), 0.0, Twist2D())
    frame.enter(Pose2D(1.0, 0.0, 0.0), CYCLE_S, Twist2D())
    assert frame.enter(Pose2D(1.0, 2.0, math.pi / 2), CYCLE_S, Twist2D()) == Pose2D()
    placed = frame.place(Pose2D(1.0, 3.0, math.pi / 2))
    assert (placed.x_m, placed.y_m, placed.theta) == pytest.approx((1.0, 0.0, 0.0))


def test_over_a_long_pause_a_jump_is_not_carried_on_for_its_whole_length():
    frame = LocalFrame(BASE)
    frame.enter(Pose2D(), 0.0, Twist2D())
    here = frame.enter(Pose2D(0.0, 50.0, 0.0), 20.0, Twist2D(0.5, 0.0))
    assert here.x_m <= 0.5
    assert here.y_m == 0
