# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The map of what was seen: what each kind of beam says, what fades, what stays, and how far the map reaches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import ObstacleMap, raycast
from navigation_scenes import insert, map_with, p3dx, put, see, wall

CELL_M, WIDE_M = 0.05, 0.2
METRES = st.floats(-200, 200)


def empty():
    return map_with(np.zeros((0, 2)), CELL_M)


def pass_through(map_, times, y=0.0):
    for _ in range(times):
        insert(map_, [np.inf], (0.0, y, 0.0))


@given(x=st.floats(-4, 4), y=st.floats(-4, 4), gap_m=st.floats(0.2, 1), cell_m=st.sampled_from([0.02, 0.05, 0.1]))
def test_a_gap_is_as_wide_as_it_is_wherever_it_lies(x: float, y: float, gap_m: float, cell_m: float) -> None:
    left, right = sorted(map_with([[x, y], [x + gap_m, y]], cell_m).points()[:, 0])
    assert right - left == pytest.approx(gap_m, abs=1e-5)
    assert left == pytest.approx(x, abs=1e-5)


def test_a_cell_remembers_the_mean_of_its_points() -> None:
    map_ = map_with([[1.01, 1.01], [1.03, 1.01], [1.02, 1.04]])
    np.testing.assert_allclose(map_.points(), [[1.02, 1.02]], atol=1e-6)


def test_a_beam_that_is_not_a_number_says_nothing() -> None:
    map_ = map_with([[1.0, 0.0]])
    for _ in range(20):
        insert(map_, [np.nan])
    assert len(map_.points()) == 1 and not map_.seen(0.5, 0.0)


def test_an_infinite_beam_is_free_up_to_range_max_but_no_farther_than_beams_are_dense() -> None:
    near, far = empty(), map_with(np.zeros((0, 2)), target=(40.0, 0.0))
    insert(near, [np.inf], range_max_m=2.0)
    insert(far, [np.inf], range_max_m=40.0)
    assert near.seen(1.99, 0.0) and not near.seen(2.06, 0.0)
    assert far.seen(9.9, 0.0) and not far.seen(10.1, 0.0)
    assert len(near.points()) == len(far.points()) == 0


@pytest.mark.parametrize("range_m", [-np.inf, 0.0, 0.05])
def test_what_is_nearer_than_range_min_is_an_obstacle_there(range_m: float) -> None:
    map_ = empty()
    insert(map_, [range_m], (1.0, 1.0, math.pi / 2), range_min_m=0.1)
    np.testing.assert_allclose(map_.points(), [[1.0, 1.1]], atol=1e-6)


def test_a_single_near_beam_counts_at_once() -> None:
    map_ = empty()
    see(map_)
    insert(map_, [0.4])
    np.testing.assert_allclose(map_.points(), [[0.4, 0.0]], atol=1e-6)


def test_a_finite_beam_beyond_range_max_is_free_as_an_infinite_one() -> None:
    map_ = empty()
    insert(map_, [3.0], range_max_m=2.0)
    assert map_.seen(1.99, 0.0) and len(map_.points()) == 0


def test_a_beam_says_nothing_about_what_is_behind_its_end_or_right_before_it() -> None:
    map_ = map_with([[1.0, 0.0], [1.05, 0.0], [1.3, 0.0]])
    for _ in range(20):
        insert(map_, [1.1])
    assert {round(x, 2) for x in map_.points()[:, 0]} == {1.05, 1.1, 1.3}


def test_what_beams_come_through_fades_sooner_where_it_was_seen_once() -> None:
    once, often = empty(), empty()
    put(once, [[1.0, 0.0]])
    put(often, [[1.0, 0.0]] * 50)
    pass_through(once, 2)
    assert len(once.points()) == 1
    pass_through(once, 1)
    pass_through(often, 11)
    assert len(once.points()) == 0 and len(often.points()) == 1
    pass_through(often, 1)
    assert len(often.points()) == 0


def test_what_is_seen_again_after_it_had_gone_is_where_it_is_now() -> None:
    map_ = map_with([[1.01, 0.0]] * 5)
    pass_through(map_, 12)
    put(map_, [[1.04, 0.01]])
    np.testing.assert_allclose(map_.points(), [[1.04, 0.01]], atol=1e-6)


def test_a_wall_that_beams_graze_stays_in_the_cells_that_they_share() -> None:
    map_ = map_with(wall((0.5, 0.01), (3.0, 0.01)))
    before = map_.points()
    pass_through(map_, 50, y=0.04)
    np.testing.assert_array_equal(map_.points(), before)
    pass_through(map_, 50, y=0.02)
    assert len(map_.points()) == 0


@given(angle=st.floats(-math.pi, math.pi), off_m=st.floats(0.15, 1.5))
def test_a_wall_seen_again_and_again_at_any_angle_stays_whole(angle: float, off_m: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    segment = [[-3 * c - off_m * s, -3 * s + off_m * c, 3 * c - off_m * s, 3 * s + off_m * c]]
    ranges, _ = raycast(segment, (0, 0, 0), -math.pi, math.pi / 360, 720, 8.0)
    map_ = empty()
    insert(map_, ranges, angle_min=-math.pi, step=math.pi / 360)
    before = map_.points()
    for _ in range(20):
        insert(map_, ranges, angle_min=-math.pi, step=math.pi / 360)
    assert len(map_.points()) == len(before) > 20
    np.testing.assert_allclose(map_.points() @ [-s, c], off_m, atol=1e-5)


def test_every_beam_is_placed_by_its_own_pose() -> None:
    map_ = empty()
    poses = [[0, 0, 0], [1, 0, math.pi / 2], [0, 1, 0]]
    map_.insert(poses, [2.0, 1.0, np.inf], 0.0, 0.0, 0.0, 10.0, 0)
    np.testing.assert_allclose(sorted(map_.points().tolist()), [[1, 1], [2, 0]], atol=1e-6)
    assert map_.seen(3.0, 1.0)


def test_outside_of_the_window_nothing_is_kept() -> None:
    map_ = ObstacleMap(CELL_M)
    insert(map_, [1.0, np.inf])
    assert len(map_.points()) == 0 and not map_.seen(0.5, 0.0)
    map_.cover(0, 0, 0, 0)
    put(map_, [[1000.0, 1000.0], [-8.0, 0.0]])
    assert len(map_.points()) == 0


def spans(map_):
    """(first, last) metres along x and y."""
    column, row, columns, rows = map_.window
    return np.array([[column, column + columns], [row, row + rows]]) * WIDE_M


@given(st.lists(st.tuples(METRES, METRES, METRES, METRES), min_size=1, max_size=6))
def test_the_window_holds_the_base_and_the_target_where_both_fit_and_is_bounded(places) -> None:
    map_ = ObstacleMap(WIDE_M)
    for x, y, target_x, target_y in places:
        map_.cover(x, y, target_x, target_y)
        for (low, high), base, target in zip(spans(map_), (x, y), (target_x, target_y)):
            assert high - low <= 60.0 + 1e-9
            assert low <= base - 5 + 1e-9 and high >= base + 5 - 1e-9
            if abs(base - target) <= 50 - 2 * WIDE_M:
                assert low <= target - 5 + 1e-9 and high >= target + 5 - 1e-9


@given(st.lists(st.tuples(METRES, METRES, METRES, METRES), min_size=2, max_size=5), st.integers(0, 99))
def test_growing_and_moving_keep_what_overlaps(places, seed: int) -> None:
    map_ = ObstacleMap(WIDE_M)
    map_.cover(*places[0])
    (x0, x1), (y0, y1) = spans(map_)
    put(map_, np.random.default_rng(seed).uniform((x0, y0), (x1, y1), (40, 2)))
    for place in places[1:]:
        before = map_.points()
        map_.cover(*place)
        (x0, x1), (y0, y1) = spans(map_)
        inside = ((before > (x0 + 1e-3, y0 + 1e-3)) & (before < (x1 - 1e-3, y1 - 1e-3))).all(axis=1)
        after = {tuple(point) for point in map_.points()}
        assert after >= {tuple(point) for point in before[inside]}
        assert after <= {tuple(point) for point in before}


def test_a_window_that_is_large_enough_stays_and_one_that_is_not_changes_seldom() -> None:
    map_ = ObstacleMap(WIDE_M)
    windows = set()
    for x in np.arange(0, 100, 0.02):
        map_.cover(x, 0, 100, 0)
        windows.add(map_.window)
    assert len(windows) < 15


def test_where_the_base_stands_nothing_is_but_at_the_rim_of_its_hull() -> None:
    inside, rim, outside = [1.0, 1.15], [1.205, 1.0], [1.0, 1.25]
    map_ = map_with([inside, rim, outside])
    map_.stand(p3dx(), (1.0, 1.0, math.pi / 2), 0.02)
    np.testing.assert_allclose(sorted(map_.points().tolist()), [outside, rim], atol=1e-6)
    assert map_.seen(1.0, 0.75) and map_.seen(0.85, 1.15) and not map_.seen(1.3, 1.0)


def test_what_came_to_where_beams_had_come_through_has_an_age_and_what_always_was_there_has_none() -> None:
    map_ = map_with([[1.0, 0.0]])
    pass_through(map_, 4, y=1.025)
    insert(map_, [1.0], (0.0, 1.025, 0.0), at_s=5.0)
    insert(map_, [1.0], (0.0, 1.025, 0.0), at_s=7.0)
    ages = map_.ages([[1.0, 0.0], [1.0, 1.025], [2.0, 2.0], [1e9, 0.0]], round(7.5e9))
    assert ages.tolist() == [math.inf, 2.5, math.inf, math.inf]


def test_ages_hold_while_the_stamps_milliseconds_wrap() -> None:
    map_ = empty()
    wrap_s = 2**32 / 1e3
    pass_through(map_, 4, y=0.025)
    insert(map_, [1.0], (0.0, 0.025, 0.0), at_s=wrap_s - 1)
    assert map_.ages([[1.0, 0.025]], round((wrap_s + 1) * 1e9)).tolist() == [2.0]


GOOD = {
    "poses": [[0, 0, 0]],
    "ranges_m": [1.0],
    "angle_min": 0,
    "angle_increment": 0.1,
    "range_min_m": 0,
    "range_max_m": 9,
    "stamp_ns": 0,
}


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"poses": [[0, 0]]}, r"poses: expected shape \[n, 3\], got \[1, 2\]"),
        ({"poses": [[0, math.nan, 0]]}, "poses: expected finite numbers, got nan at index 1"),
        ({"poses": [[1e6, 0, 0]]}, "poses: expected at most 100 km, got 1e\\+06 m"),
        ({"ranges_m": [1.0, 2.0]}, r"ranges_m: expected shape \[1\], got \[2\]"),
        ({"angle_min": math.nan}, "angle_min, angle_increment: expected finite numbers, got nan at index 0"),
        ({"angle_increment": math.inf}, "angle_min, angle_increment: expected finite numbers, got inf at index 1"),
        ({"range_min_m": -1}, "range_min: expected a finite number of at least 0, got -1"),
        ({"range_min_m": math.nan}, "range_min: expected a finite number of at least 0, got nan"),
        ({"range_max_m": math.nan}, "range_max: expected more than range_min, 0, got nan"),
        ({"range_min_m": 9}, "range_max: expected more than range_min, 9, got 9"),
    ],
)
def test_a_scan_that_is_none_is_refused_by_name(changed: dict, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        empty().insert(**{**GOOD, **changed})


@pytest.mark.parametrize("cell_m", [0.0, -0.05, 0.001, math.nan, math.inf])
def test_cells_without_size_or_smaller_than_a_centimetre_are_refused(cell_m: float) -> None:
    with pytest.raises(ValueError, match=r"^cell: expected a finite number of at least 0.01, got "):
        ObstacleMap(cell_m)


@pytest.mark.parametrize("place", [(math.nan, 0, 0, 0), (0, 0, math.inf, 0), (0, -1e300, 0, 0), (0, 0, 0, 1.1e5)])
def test_places_that_no_map_holds_are_refused(place) -> None:
    with pytest.raises(ValueError, match=r"^base, target: expected "):
        empty().cover(*place)


@pytest.mark.parametrize("far", [math.nan, math.inf, -math.inf, 1e300, -1e300, 1e12])
def test_nothing_was_seen_far_off_the_map(far: float) -> None:
    map_ = map_with([[1.0, 0.0]])
    assert not map_.seen(far, 0.0) and not map_.seen(0.0, far)
