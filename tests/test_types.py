# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Poses and velocities in the plane: they compose, come back, and are finite."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.types import FARTHEST_M, STILL, Goal, Pose2D, Scan, Twist2D

METRES, ANGLES = st.floats(-1e3, 1e3), st.floats(-10, 10)
POSES = st.builds(Pose2D, METRES, METRES, ANGLES)
TWISTS = st.builds(Twist2D, st.floats(-2, 2), st.floats(-3, 3))


def assert_same(a: Pose2D, b: Pose2D, tolerance: float = 1e-9) -> None:
    assert (a.x_m, a.y_m) == pytest.approx((b.x_m, b.y_m), abs=tolerance)
    assert math.remainder(a.theta - b.theta, 2 * math.pi) == pytest.approx(0, abs=tolerance)


@given(POSES, POSES)
def test_what_is_relative_to_a_pose_composed_with_it_comes_back(a: Pose2D, b: Pose2D) -> None:
    assert_same(a.compose(b.relative_to(a)), b)
    assert_same(a.compose(b).relative_to(a), b)


@given(POSES, POSES)
def test_composing_multiplies_the_transforms(a: Pose2D, b: Pose2D) -> None:
    np.testing.assert_allclose(a.compose(b).matrix(), a.matrix() @ b.matrix(), atol=1e-9)


@given(POSES, POSES, POSES)
def test_composing_may_begin_at_either_end(a: Pose2D, b: Pose2D, c: Pose2D) -> None:
    assert_same(a.compose(b).compose(c), a.compose(b.compose(c)))


@given(POSES)
def test_a_pose_is_nowhere_from_itself(pose: Pose2D) -> None:
    assert_same(pose.relative_to(pose), STILL)
    assert_same(pose.relative_to(STILL), pose)


def test_a_pose_ahead_of_one_that_looks_left_is_left_in_the_world() -> None:
    assert_same(Pose2D(1, 2, math.pi / 2).compose(Pose2D(3, 0, 0.1)), Pose2D(1, 5, math.pi / 2 + 0.1))


@given(POSES, POSES)
def test_directions_stay_within_half_a_turn(a: Pose2D, b: Pose2D) -> None:
    assert abs(a.compose(b).theta) <= math.pi and abs(a.relative_to(b).theta) <= math.pi


@given(TWISTS, st.floats(0, 10), st.floats(0, 10))
def test_a_motion_is_the_motion_of_its_parts(twist: Twist2D, first_s: float, then_s: float) -> None:
    assert_same(twist.motion(first_s).compose(twist.motion(then_s)), twist.motion(first_s + then_s))
    assert_same(twist.motion(-first_s), STILL.relative_to(twist.motion(first_s)))


def test_half_a_circle_ends_one_diameter_to_the_left() -> None:
    assert_same(Twist2D(1.0, 0.5).motion(2 * math.pi), Pose2D(0, 4, math.pi))


@pytest.mark.parametrize("w_radps", [0.0, 5e-324, 1e-12, 1e-8, -1e-8, 1e-6])
def test_the_straightest_arcs_are_exact_too(w_radps: float) -> None:
    motion = Twist2D(2.0, w_radps).motion(1.0)
    assert motion.x_m == pytest.approx(2.0, rel=1e-12)
    assert motion.y_m == pytest.approx(w_radps, rel=1e-9)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(value: float) -> None:
    for make, name in ((lambda: Pose2D(0, value), "pose"), (lambda: Twist2D(0, value), "twist")):
        with pytest.raises(ValueError, match=rf"^{name}: expected finite values, got \(0, {value}"):
            make()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"ranges_m": [[1.0, 2.0]]}, r"ranges_m: expected shape \[n\], got \[1, 2\]"),
        ({"angle_min": math.inf}, "angles: expected finite values, got inf and 0.1"),
        ({"range_min_m": math.nan}, "range_min_m: expected a finite number of at least 0, got nan"),
        ({"range_min_m": -0.1}, "range_min_m: expected a finite number of at least 0, got -0.1"),
        ({"range_max_m": math.nan}, "range_max_m: expected above range_min_m, 0.0, got nan"),
        ({"range_min_m": 2.0, "range_max_m": 2.0}, "range_max_m: expected above range_min_m, 2.0, got 2.0"),
        ({"beam_dt_ns": [0, 1]}, r"beam_dt_ns: expected shape \[3\], got \[2\]"),
        ({"beam_dt_ns": [[0, 1, 2]]}, r"beam_dt_ns: expected shape \[3\], got \[1, 3\]"),
    ],
)
def test_a_scan_that_no_laser_could_measure_is_refused_by_name(changed: dict, said: str) -> None:
    good = {"ranges_m": np.ones(3), "angle_min": 0.0, "angle_increment": 0.1, "beam_dt_ns": [0, 1, 2]}
    Scan(0, **good)
    with pytest.raises(RefusedError, match=f"^{said}$"):
        Scan(0, **{**good, **changed})


@pytest.mark.parametrize("sign", [1, -1])
def test_a_goal_is_nowhere_that_no_map_reaches(sign: int) -> None:
    Goal("near", Pose2D(sign * FARTHEST_M, -sign * FARTHEST_M))
    beyond = sign * (FARTHEST_M + 1)
    for pose in (Pose2D(beyond, 0), Pose2D(0, beyond)):
        with pytest.raises(RefusedError, match=r"^goal far: expected coordinates up to 50000 m, got Pose2D\("):
            Goal("far", pose)
