# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's potential: known values, a gradient that is its own, and a push that does not count the beams."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from edgefusion.config import KhatibConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.khatib import GAP_M, STEEPEST_M, descend, gradient, nearest_per_thing, potential

CONFIG = KhatibConfig(attraction=2.0, repulsion=0.1, threshold_m=1.0, hysteresis_m=0.2, near_gain=0.5, far_gain=1.0)
NONE = np.empty((0, 2))
COORDINATES = st.floats(-3, 3)
POINTS = st.tuples(COORDINATES, COORDINATES)


def arc(range_m: float, begin: float, end: float, beams: int) -> np.ndarray:
    angles = np.linspace(begin, end, beams)
    return range_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_attraction_is_a_parabola_near_the_goal_and_a_cone_farther_away() -> None:
    assert potential((0.5, 0), NONE, CONFIG) == pytest.approx(2 * 0.25 / 2)
    assert potential((0, 1), NONE, CONFIG) == pytest.approx(1.0)
    assert potential((3, 4), NONE, CONFIG) == pytest.approx(1.0 + 4 * 2.0)
    assert gradient((0.5, 0), NONE, CONFIG) == pytest.approx([-1.0, 0])
    assert gradient((3, 4), NONE, CONFIG) == pytest.approx([-2 * 0.6, -2 * 0.8])
    assert gradient((0, 0), NONE, CONFIG) == pytest.approx([0, 0])


def test_repulsion_is_khatibs_within_the_threshold_and_nothing_from_there_on() -> None:
    assert potential((0, 0), [(0.5, 0)], CONFIG) == pytest.approx(0.5 * 0.1 * (2 - 1) ** 2)
    assert gradient((0, 0), [(0.5, 0)], CONFIG) == pytest.approx([0.1 * (2 - 1) * 4, 0])
    assert potential((0, 0), [(0, -1.0)], CONFIG) == 0
    assert gradient((0, 0), [(0, -1.0)], CONFIG) == pytest.approx([0, 0])


@given(POINTS, st.lists(POINTS, max_size=5))
def test_the_gradient_is_the_numerical_one_of_the_potential(goal, things) -> None:
    assume(all(math.hypot(*thing) > 1e-3 for thing in things))
    goal_m, things_m, step_m = np.array(goal), np.array(things, float).reshape(-1, 2), 1e-6
    numerical = [
        (potential(goal_m - dq, things_m - dq, CONFIG) - potential(goal_m + dq, things_m + dq, CONFIG)) / (2 * step_m)
        for dq in step_m * np.eye(2)
    ]
    exact = gradient(goal_m, things_m, CONFIG)
    assert exact == pytest.approx(numerical, rel=1e-3, abs=1e-3 * (1 + np.abs(exact).max()))


@given(POINTS, st.lists(POINTS, max_size=4))
def test_a_single_thing_pushes_away_and_never_harder_than_at_its_steepest(goal, things) -> None:
    for thing in things:
        push = -gradient((0, 0), [thing], CONFIG)
        assert push @ np.array(thing) <= 0
        assert np.hypot(*push) <= CONFIG.repulsion * (1 / STEEPEST_M - 1) / STEEPEST_M**2 * (1 + 1e-9)
    assert np.isfinite(gradient(goal, [(0, 0)], CONFIG)).all()


@given(st.integers(2, 50), st.floats(-2, 2), st.floats(0.2, 0.9))
def test_a_thing_repels_by_its_place_not_by_its_number_of_beams(beams: int, bearing: float, range_m: float) -> None:
    few = np.vstack([arc(range_m + 0.05, bearing - 0.1, bearing, 3), arc(range_m, bearing, bearing, 1)])
    many = np.vstack([arc(range_m + 0.05, bearing - 0.1, bearing, 3 * beams), arc(range_m, bearing, bearing, 1)])
    u_few, u_many = (descend((2, 0), points, True, CONFIG).u_mps for points in (few, many))
    assert u_few == pytest.approx(u_many)


def test_things_are_runs_of_beams_and_each_counts_by_its_nearest_point() -> None:
    left, right = arc(0.8, 0.5, 0.9, 20), arc(0.6, -0.9, -0.5, 20)
    right[7] *= 0.8
    things_m = nearest_per_thing(np.vstack([right, left]), 1.0)
    assert len(things_m) == 2
    assert things_m[0] == pytest.approx(right[7])
    assert np.hypot(*things_m[1]) == pytest.approx(0.8)


def test_points_out_of_reach_are_no_things_and_part_those_in_reach() -> None:
    wall = np.stack([np.full(101, 0.5), np.linspace(-2, 2, 101)], axis=1)
    assert nearest_per_thing(wall, 1.0) == pytest.approx(np.array([[0.5, 0.0]]))
    assert nearest_per_thing(wall, 0.4).shape == (0, 2)
    corridor = np.vstack([arc(0.5, -1.6, -1.5, 5), [[4.0, 0.0]], arc(0.5, 1.5, 1.6, 5)])
    assert len(nearest_per_thing(corridor, 1.0)) == 2


@given(st.lists(POINTS, max_size=40), st.floats(0.1, 3))
def test_every_run_has_one_nearest_point_which_is_one_of_its_own(points, reach_m: float) -> None:
    inside = [np.array(point) for point in points if math.hypot(*point) < reach_m]
    runs: list[list[np.ndarray]] = []
    for point in inside:
        if runs and math.hypot(*(point - runs[-1][-1])) <= GAP_M:
            runs[-1].append(point)
        else:
            runs.append([point])
    found = nearest_per_thing(np.array(points, float).reshape(-1, 2), reach_m)
    assert len(found) == len(runs)
    for thing, run in zip(found, runs):
        assert any((thing == point).all() for point in run)
        assert math.hypot(*thing) == min(math.hypot(*point) for point in run)


def test_with_nothing_near_the_higher_gain_drives_and_with_hysteresis_it_takes_over_again() -> None:
    goal = (2.0, 0.0)
    near, neutral, far = ([(0.0, y)] for y in (0.99, 1.1, 1.21))
    for points, was_near, is_near in [
        (near, False, True),
        (near, True, True),
        (neutral, False, False),
        (neutral, True, True),
        (far, True, False),
        (NONE, True, False),
    ]:
        u_mps, found_near = descend(goal, points, was_near, CONFIG)
        assert found_near is is_near
        assert u_mps[0] == pytest.approx(2.0 * (0.5 if is_near else 1.0))


def test_where_pull_and_push_cancel_out_it_sticks() -> None:
    """The local minimum that the navigation function is for: right in front of a thing before the goal."""
    lo, hi = 0.1, 0.9
    for _ in range(60):
        middle = (lo + hi) / 2
        ahead = descend((middle + 2, 0), [(middle, 0)], True, CONFIG).u_mps[0] > 0
        lo, hi = (lo, middle) if ahead else (middle, hi)
    assert descend((lo + 2, 0), [(lo, 0)], True, CONFIG).u_mps == pytest.approx([0, 0], abs=1e-9)
    assert 2.0 == pytest.approx(0.1 * (1 / lo - 1) / lo**2)


@pytest.mark.parametrize(
    ("goal", "points", "message"),
    [
        ((1, 2, 3), NONE, r"goal_m: expected shape \[2\], got \[3\]"),
        ((math.nan, 0), NONE, "goal_m: expected finite values, got nan"),
        ((1, 0), [(1, 2, 3)], r"points_m: expected shape \[n, 2\], got \[1, 3\]"),
        ((1, 0), [(1, math.inf)], "points_m: expected finite values, got inf"),
    ],
)
def test_what_is_no_place_is_refused_with_its_name(goal, points, message: str) -> None:
    with pytest.raises(RefusedError, match=message):
        descend(goal, points, False, CONFIG)
