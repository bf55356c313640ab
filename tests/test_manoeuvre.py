# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Manoeuvres: every leg is an arc that can be driven, clear of everything, and where there is none the search ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from edgefusion._core import Footprint, Manoeuvre, NavigationFunction
from navigation_scenes import P3DX, box, computed, distance, lines_gap, map_with, p3dx, put, wall

MARGIN_M = 0.02
STRIDE_M = 0.012
"""Between two poses that are tried no corner moves farther."""
NO_OTHERS = np.zeros((0, 2))
START = (0.0, 0.0, 0.0)
MOST_POSES = 200_000


def searched(map_, function, start=START, others=NO_OTHERS, margin_m=MARGIN_M, hull=None, portion=MOST_POSES, **target):
    manoeuvre = Manoeuvre(hull or p3dx())
    manoeuvre.begin(map_, function, start, margin_m, others, **target)
    looked_at = 0
    while not manoeuvre.advance(map_, function, portion):
        looked_at += portion
        assert manoeuvre.running and looked_at < MOST_POSES
    assert not manoeuvre.running
    return manoeuvre.legs


def along(pose, way, turn, share):
    """On an exact arc, or turning on the spot."""
    x, y, theta = pose
    way, turn = share * way, share * turn
    chord = way * np.sinc(turn / 2 / math.pi)
    return np.stack([x + chord * np.cos(theta + turn / 2), y + chord * np.sin(theta + turn / 2), theta + turn], axis=-1)


def driven(start, legs):
    """All poses on the legs, in steps of millimetres, beginning every leg where the last one led to."""
    poses = [np.array([start])]
    for way, turn, end in legs:
        steps = max(2, math.ceil((abs(way) + 0.4 * abs(turn)) / 0.004))
        poses.append(along(poses[-1][-1], way, turn, np.linspace(0, 1, steps)))
        np.testing.assert_allclose(poses[-1][-1], end, atol=1e-6)
    return np.concatenate(poses)


def assert_clear(start, legs, points, margin_m=MARGIN_M, corners=P3DX):
    assert distance(corners, driven(start, legs), points).min() > margin_m - STRIDE_M / 2


def known_map(points, target=(0.0, 0.0), base=(0.0, 0.0)):
    return map_with(points, base=base, target=target, seen_m=4.0)


def posts(seed, n):
    return np.random.default_rng(seed).uniform(-1.6, 1.6, (n, 2))


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.floats(-math.pi, math.pi))
def test_legs_are_arcs_that_end_where_they_say_clear_of_everything_down_the_function(seed: int, theta: float) -> None:
    start, points = (0.0, 0.0, theta), posts(seed, 25)
    assume(lines_gap(P3DX, start, points).min() > 0.05)
    map_ = known_map(points, (4.0, 0.0))
    function = computed(map_, (4.0, 0.0), blocked_m=0.19)
    target_m = function.value(0, 0) - 0.6
    assume(math.isfinite(target_m))
    legs = searched(map_, function, start, value_m=target_m)
    if not legs:
        return
    assert_clear(start, legs, map_.points())
    x, y, heading = legs[-1][2]
    assert function.value(x, y) <= target_m
    dx, dy = function.descent(x, y)
    assert abs(math.remainder(math.atan2(dy, dx) - heading, 2 * math.pi)) < 0.5


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.floats(-1, 1), st.floats(-1, 1), st.floats(-math.pi, math.pi))
def test_a_pose_is_reached_within_its_tolerances(seed: int, x: float, y: float, theta: float) -> None:
    points, goal = posts(seed, 12), (x, y, theta)
    assume(lines_gap(P3DX, START, points).min() > 0.05)
    map_ = known_map(points)
    tolerances = {"position_tolerance_m": 0.08, "heading_tolerance": 0.15}
    legs = searched(map_, computed(map_, (0.0, 0.0)), pose=goal, **tolerances)
    if legs:
        assert_clear(START, legs, map_.points())
        end = legs[-1][2]
        assert math.hypot(end[0] - x, end[1] - y) <= 0.08
        assert abs(math.remainder(end[2] - theta, 2 * math.pi)) <= 0.15 + 1e-9


def test_in_free_space_the_way_ahead_is_one_straight_leg_and_a_turn_a_turn() -> None:
    map_ = known_map(NO_OTHERS)
    function = computed(map_, (0.0, 0.0))
    ((way, turn, _),) = searched(map_, function, pose=(0.8, 0.0, 0.0))
    assert turn == 0 and way == pytest.approx(0.8, abs=0.05)
    ((way, turn, _),) = searched(map_, function, pose=(0.0, 0.0, math.pi / 2))
    assert way == 0 and turn == pytest.approx(math.pi / 2, abs=0.05)


def test_the_end_of_a_leg_tells_which_way_it_turned() -> None:
    map_ = known_map(NO_OTHERS)
    legs = searched(map_, computed(map_, (0.0, 0.0)), pose=(0.0, 0.0, math.pi))
    assert len(legs) == 2 and all(way == 0 for way, _, _ in legs)
    assert abs(sum(turn for _, turn, _ in legs)) == pytest.approx(math.pi, abs=0.15)
    heading = 0.0
    for _, turn, end in legs:
        assert math.remainder(end[2] - heading, 2 * math.pi) == pytest.approx(turn)
        heading = end[2]


@settings(max_examples=8)
@given(st.integers(0, 10**6), st.integers(1, 5000))
def test_portions_give_the_same_legs(seed: int, portion: int) -> None:
    points = posts(seed, 8)
    assume(lines_gap(P3DX, START, points).min() > 0.05)
    map_ = known_map(points)
    function = computed(map_, (0.0, 0.0))
    whole = searched(map_, function, pose=(-0.6, 0.7, 2.0))
    assert searched(map_, function, pose=(-0.6, 0.7, 2.0), portion=max(portion, 20)) == whole


def dead_end(width_m, end_m=0.35):
    """Around the start, ahead of it closed; 1.2 m behind it is open."""
    y = width_m / 2
    return np.concatenate([wall((-1.2, y), (end_m, y)), wall((-1.2, -y), (end_m, -y)), wall((end_m, -y), (end_m, y))])


def test_a_dead_end_narrower_than_the_turning_circle_is_left_backwards() -> None:
    """A Pioneer turns in 0.74 m."""
    points = dead_end(0.60)
    map_ = known_map(points, (-3.0, 0.0))
    function = computed(map_, (-3.0, 0.0), blocked_m=0.19)
    legs = searched(map_, function, value_m=function.value(0, 0) - 1.6)
    assert legs and legs[0][0] < 0
    poses = driven(START, legs)
    assert poses[np.abs(poses[:, 2]) < 0.5, 0].min() < -0.6
    assert_clear(START, legs, map_.points())


def test_out_of_a_dead_end_that_is_wide_enough_nobody_backs() -> None:
    map_ = known_map(dead_end(1.4, 0.7), (-3.0, 0.0))
    function = computed(map_, (-3.0, 0.0), blocked_m=0.19)
    legs = searched(map_, function, value_m=function.value(0, 0) - 0.6)
    assert legs and all(way >= 0 for way, _, _ in legs)


def test_nobody_backs_over_ground_that_was_not_seen() -> None:
    map_ = map_with(dead_end(0.60), target=(-3.0, 0.0))
    for y in np.linspace(-0.2, 0.2, 17):
        map_.insert([[-0.3, y, 0.0]], [0.64], 0.0, 0.1, 0.0, 9.0, 0)
    map_.stand(p3dx(), START, 0.02)
    function = computed(map_, (-3.0, 0.0), blocked_m=0.19)
    assert searched(map_, function, value_m=function.value(0, 0) - 1.6) == []


def test_who_is_walled_in_gets_no_legs_after_bounded_work() -> None:
    map_ = known_map(box(-0.45, -0.45, 0.45, 0.45))
    function = computed(map_, (3.0, 0.0))
    assert searched(map_, function, pose=(1.2, 0.0, 0.0), portion=1000) == []
    assert searched(map_, function, value_m=0.5) == []


def test_a_pose_beyond_the_search_ends_without_legs() -> None:
    map_ = known_map(NO_OTHERS)
    assert searched(map_, computed(map_, (0.0, 0.0)), pose=(3.0, 0.0, 0.0)) == []


def test_others_are_kept_clear_of_as_the_maps_points_are() -> None:
    map_ = known_map(NO_OTHERS)
    function, others = computed(map_, (0.0, 0.0)), wall((0.5, -0.3), (0.5, 0.3))
    free, around = (searched(map_, function, others=o, pose=(1.0, 0.0, 0.0)) for o in (NO_OTHERS, others))
    assert len(free) == 1
    assert around and len(around) > 1
    assert_clear(START, around, others)


def test_a_base_within_the_margin_gets_away_from_where_it_is() -> None:
    map_ = known_map(wall((0.215, -0.2), (0.215, 0.2)))
    function = computed(map_, (0.0, 0.0))
    legs = searched(map_, function, pose=(-0.5, 0.0, 0.0), position_tolerance_m=0.08)
    assert legs and legs[0][0] < 0
    assert distance(P3DX, driven(START, legs), map_.points()).min() > 0


def test_a_long_base_keeps_clear_of_what_is_far_from_its_axle() -> None:
    corners = np.array([[1.6, 0.2], [-0.2, 0.2], [-0.2, -0.2], [1.6, -0.2]])
    goal = {"pose": (1.5, 0.0, 0.0), "position_tolerance_m": 0.06, "heading_tolerance": 0.1}
    for ahead_m, reached in ((3.2, True), (3.05, False)):
        map_ = map_with(wall((ahead_m, -0.2), (ahead_m, 0.2), 0.1), target=(5.0, 0.0), seen_m=6.0)
        put(map_, np.concatenate([wall((-0.4, 0.28), (3, 0.28), 0.1), wall((-0.4, -0.28), (3, -0.28), 0.1)]))
        legs = searched(map_, computed(map_, (0.0, 0.0)), hull=Footprint(corners), **goal)
        assert bool(legs) == reached
        if legs:
            assert_clear(START, legs, map_.points(), corners=corners)


@pytest.mark.parametrize("margin_m", [0.1, 0.3])
def test_a_wide_margin_is_kept(margin_m: float) -> None:
    map_ = known_map(wall((0.7, -0.9), (0.7, 0.1)))
    legs = searched(map_, computed(map_, (0.0, 0.0)), margin_m=margin_m, pose=(1.4, 0.0, 0.0))
    assert legs
    assert_clear(START, legs, map_.points(), margin_m)


def test_before_it_was_begun_it_is_over_and_there_are_no_legs() -> None:
    map_ = known_map(NO_OTHERS)
    manoeuvre = Manoeuvre(p3dx())
    assert not manoeuvre.running and manoeuvre.legs == []
    assert manoeuvre.advance(map_, NavigationFunction(0.2, 0.7, 4.0), 10)


def test_another_beginning_forgets_the_last_legs() -> None:
    map_ = known_map(NO_OTHERS)
    function, manoeuvre = computed(map_, (0.0, 0.0)), Manoeuvre(p3dx())
    manoeuvre.begin(map_, function, START, MARGIN_M, NO_OTHERS, pose=(0.5, 0.0, 0.0))
    assert manoeuvre.advance(map_, function, MOST_POSES) and manoeuvre.legs
    manoeuvre.begin(map_, function, START, MARGIN_M, NO_OTHERS, pose=(-0.5, 0.0, 0.0))
    assert manoeuvre.running and manoeuvre.legs == []


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"start": (0, math.nan, 0)}, "pose: expected finite numbers, got nan at index 1"),
        ({"margin_m": math.nan}, "start, margin, target: expected finite numbers, got nan at index 3"),
        ({"margin_m": -0.1}, "margin: expected from 0 to 1, got -0.1"),
        ({"others": [[0, math.inf]]}, "others: expected finite numbers, got inf at index 1"),
        ({"others": [[0, 1, 2]]}, r"others: expected shape \[n, 2\], got \[1, 3\]"),
        ({"pose": None}, "value, pose: expected one of them, got both or none"),
        ({"value_m": 1.0}, "value, pose: expected one of them, got both or none"),
        ({"pose": None, "value_m": math.nan}, "start, margin, target: expected finite numbers, got nan at index 4"),
        ({"position_tolerance_m": math.inf}, "start, margin, target: expected finite numbers, got inf at index 8"),
    ],
)
def test_what_makes_no_search_is_refused_by_name(changed: dict, message: str) -> None:
    map_ = known_map(NO_OTHERS)
    good = {"start": START, "margin_m": MARGIN_M, "others": NO_OTHERS, "pose": (1, 0, 0)}
    with pytest.raises(ValueError, match=f"^{message}$"):
        Manoeuvre(p3dx()).begin(map_, computed(map_, (0.0, 0.0)), **{**good, **changed})
