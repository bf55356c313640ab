# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The navigation function: as long as the way is, without local minima, around whatever was seen."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion._core import NavigationFunction, ObstacleMap
from navigation_scenes import box, computed, map_with, put, see, wall

CELL_M = 0.1
BLOCKED_M = 0.2
EMPTY = np.zeros((0, 2))


def around(seed, n, inner_m=0.0, outer_m=6.0):
    rng = np.random.default_rng(seed)
    angle, radius = rng.uniform(-math.pi, math.pi, n), rng.uniform(inner_m, outer_m, n)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def random_world(seed):
    """Posts and walls, with room at the goal, the origin."""
    rng = np.random.default_rng(seed)
    walls = [wall(start, start + rng.normal(0, 1.0, 2), 0.05) for start in rng.uniform(-5, 5, (25, 2))]
    points = np.concatenate([*walls, rng.uniform(-5, 5, (60, 2))])
    return points[np.hypot(*points.T) > 0.5]


def error_in_free_space(cell_m):
    function = computed(map_with(EMPTY, cell_m), (0.02, -0.01), (6.0, 6.0))
    places = around(0, 400, 0.3, 6.0)
    true = np.hypot(*(places - (0.02, -0.01)).T)
    return np.array([function.value(x, y) for x, y in places]) - true


def test_in_free_space_it_is_the_distance_within_the_first_order_error() -> None:
    error = error_in_free_space(0.05)
    assert error.min() > -0.01 and error.max() < 0.12


def test_half_the_cells_side_gives_about_half_the_error() -> None:
    coarse, fine = np.abs(error_in_free_space(0.1)).mean(), np.abs(error_in_free_space(0.05)).mean()
    assert fine < 0.7 * coarse


def test_along_a_row_of_cells_it_is_exact() -> None:
    function = computed(map_with(EMPTY, CELL_M), (0.05, 0.05), (6.0, 0.05))
    assert function.value(5.05, 0.05) == pytest.approx(5.0, abs=1e-3)
    assert function.descent(3.05, 0.05) == pytest.approx((-1.0, 0.0), abs=1e-6)


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_from_wherever_there_is_a_value_the_way_ends_at_the_goal_and_nothing_is_touched(seed: int) -> None:
    map_ = map_with(random_world(seed), CELL_M)
    points = map_.points()
    function = computed(map_, (0.0, 0.0), (-5.0, -5.0), tolerance_m=0.1)
    reached = 0
    for x, y in around(seed, 40):
        way = function.way(x, y, 60.0, 0.0)
        if not len(way):
            assert function.value(x, y) == math.inf
            continue
        reached += 1
        assert way[0].tolist() == [x, y] and way[-1].tolist() == [0.0, 0.0]
        assert np.hypot(*np.diff(way, axis=0).T).max() <= CELL_M / 2 + 1e-9
        apart = np.hypot(*(way[:, None] - points).transpose(2, 0, 1)).min(axis=1)
        assert apart[6:].min(initial=1.0) > BLOCKED_M - 0.75 * CELL_M  # it may begin nearer
    assert reached or function.outcome == "enclosed"


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_it_falls_all_along_the_way(seed: int) -> None:
    function = computed(map_with(random_world(seed), CELL_M), (0.0, 0.0), (-5.0, -5.0), tolerance_m=0.1)
    for x, y in around(seed, 20):
        values = [function.value(*place) for place in function.way(x, y, 60.0, 0.0)]
        between = values[2:-4]  # beside unknown cells, and among the first around the goal, it is not exact
        assert all(b < a + 0.03 for a, b in zip(between, between[1:]))
        assert all(b < a - 0.05 for a, b in zip(between, between[6:]))


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.integers(1, 4000))
def test_portions_give_the_same_to_the_last_bit(seed: int, cells: int) -> None:
    map_ = map_with(random_world(seed), CELL_M)
    whole = computed(map_, (0.0, 0.0), (-4.0, 3.0))
    portions = NavigationFunction(0.2, 0.7, 4.0)
    portions.begin(map_, 0.0, 0.0, 0.05, -4.0, 3.0)
    advanced = 1
    while not portions.advance(map_, cells):
        assert portions.running
        advanced += 1
    assert not portions.running and portions.outcome == whole.outcome
    assert advanced > 1 or cells > 1000
    for x, y in around(seed, 100, 0.0, 7.0):
        assert portions.value(x, y) == whole.value(x, y)
        assert portions.descent(x, y) == whole.descent(x, y)


def test_on_a_large_map_the_costs_take_few_of_the_portions() -> None:
    map_ = map_with(EMPTY, 0.05, (-22.0, -22.0), (22.0, 22.0))
    columns, rows = map_.window[2:]
    assert columns * rows > 1_000_000
    function, portion = NavigationFunction(BLOCKED_M, 0.7, 4.0), 50_000
    function.begin(map_, 22.0, 22.0, 0.05, -22.0, -22.0)
    portions = 1
    while not function.advance(map_, portion):
        portions += 1
    assert portions <= 12 + columns * rows / portion  # the cells are marched through one portion at a time
    assert function.value(-22.0, -22.0) == pytest.approx(44 * math.sqrt(2), rel=0.01)


def test_the_last_one_stays_in_use_until_the_next_is_done() -> None:
    map_ = map_with(EMPTY, CELL_M)
    function = computed(map_, (0.0, 0.0), (3.0, 0.0))
    before = function.value(2.0, 1.0)
    function.begin(map_, 0.0, 3.0, 0.05, 3.0, 0.0)
    assert function.running and not function.advance(map_, 3000)
    assert function.value(2.0, 1.0) == before
    assert function.advance(map_, 10**9)
    assert function.value(2.0, 1.0) == pytest.approx(math.hypot(2, 2), abs=0.15)


def test_where_the_map_moves_meanwhile_it_begins_anew_for_the_same_goal() -> None:
    map_ = map_with(EMPTY, CELL_M)
    function = NavigationFunction(0.2, 0.7, 4.0)
    function.begin(map_, 0.0, 0.0, 0.05, 9.0, 0.0)
    assert not function.advance(map_, 3000)
    map_.cover(9.0, 0.0, 0.0, 0.0)
    assert function.advance(map_, 10**9) and function.outcome == "reached"
    assert function.value(9.0, 0.0) == pytest.approx(9.0, abs=0.15)


def test_before_any_was_computed_there_is_nothing() -> None:
    function = NavigationFunction(0.2, 0.7, 4.0)
    assert (function.value(0, 0), function.descent(0, 0)) == (math.inf, (0, 0))
    assert not function.running and function.way(0, 0, 1, 1).shape == (0, 2)


def test_unknown_ground_is_passable_and_its_walls_once_seen_are_not() -> None:
    u_trap = np.concatenate([wall((1, -1), (1, 1)), wall((-1, -1), (1, -1)), wall((-1, 1), (1, 1))])
    map_ = map_with(EMPTY, CELL_M)
    assert computed(map_, (3.0, 0.0)).value(0, 0) == pytest.approx(3.0, abs=0.1)
    put(map_, u_trap)
    function = computed(map_, (3.0, 0.0))
    assert function.outcome == "reached" and function.value(0, 0) > 5.0
    way = function.way(0.0, 0.0, 20.0, 0.0)
    assert way[-1].tolist() == [3.0, 0.0] and way[:, 0].min() < -1.0


def test_a_goal_in_a_closed_room_is_enclosed_and_so_is_a_base() -> None:
    map_ = map_with(box(-1, -1, 1, 1), CELL_M)
    out, into = computed(map_, (3.0, 0.0)), computed(map_, (0.0, 0.0), (3.0, 0.0))
    assert (out.outcome, into.outcome) == ("enclosed", "enclosed")
    assert out.value(0, 0) == math.inf and out.way(0, 0, 5, 0.3).shape == (0, 2)
    assert into.value(0.5, 0) < math.inf


def test_a_goal_without_room_is_occupied_unless_its_tolerance_reaches_to_where_there_is() -> None:
    map_ = map_with([[2.0, 0.0]], CELL_M)
    assert computed(map_, (2.0, 0.05)).outcome == "occupied"
    near = computed(map_, (2.0, 0.05), tolerance_m=0.4)
    assert near.outcome == "reached"
    end = near.way(0.0, 0.0, 10.0, 0.0)[-1]
    assert math.hypot(*(end - (2.0, 0.05))) < 0.4 + CELL_M


@given(angle=st.floats(-math.pi, math.pi), off_m=st.floats(0, 0.2), slide_m=st.floats(-0.5, 0.5))
def test_a_door_little_wider_than_the_base_is_open_at_any_angle(angle: float, off_m: float, slide_m: float) -> None:
    """The width of a Pioneer and 8 cm more, blocked as the navigator does: 2 cm less than its half width."""
    c, s, half_m = math.cos(angle), math.sin(angle), (0.425 + 0.08) / 2
    along, ahead = np.array([-s, c]), np.array([c, s])
    middle = (1.0 + off_m) * ahead + slide_m * along
    sides = [wall(middle + sign * half_m * along, middle + sign * 12 * along) for sign in (-1, 1)]
    map_ = map_with(np.concatenate(sides), 0.05, target=tuple(2.5 * ahead))
    function = computed(map_, tuple(2.5 * ahead), blocked_m=0.1925, comfort_m=0.7)
    assert function.outcome == "reached" and function.value(0, 0) < 12.0


@given(x=st.floats(0, 0.1), y=st.floats(0, 0.1))
def test_a_door_narrower_than_what_is_blocked_is_shut_wherever_it_lies(x: float, y: float) -> None:
    room = box(x - 1, y - 1, x + 1, y + 1)
    door = room[(room[:, 0] < x + 0.99) | (np.abs(room[:, 1] - y) > 0.15)]
    assert computed(map_with(door, 0.05), (3.0, 0.0)).outcome == "enclosed"


@given(x=st.floats(0, 0.1), y=st.floats(0, 0.1), more_m=st.floats(0.001, 0.1), angle=st.floats(-math.pi, math.pi))
def test_a_base_at_a_wall_is_not_enclosed_by_its_cells_middle(x: float, y: float, more_m: float, angle: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    middle = np.array([x, y]) + (BLOCKED_M + more_m) * np.array([c, s])
    along = 2 * np.array([-s, c])
    points = wall(middle - along, middle + along)
    function = computed(map_with(points, CELL_M), (-3 * c, -3 * s), (x, y))
    assert function.outcome == "reached"
    assert len(function.way(x, y, 1.0, BLOCKED_M + CELL_M))


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3, 2.5, -2.0])
def test_to_a_goal_beyond_the_window_the_way_leads_to_the_border_around_traps(angle: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s], [-s, c]])
    trap = np.concatenate([wall((2, -2), (2, 2)), wall((-1, -2), (2, -2)), wall((-1, 2), (2, 2))]) @ turn
    goal = (300 * c, 300 * s)
    map_ = map_with(trap, CELL_M, target=goal)
    column, row, columns, rows = map_.window
    function = computed(map_, goal)
    assert function.outcome == "reached" and 300 < function.value(0, 0) < 310
    way = function.way(0.0, 0.0, 80.0, 0.0)
    x, y = way[-1] / CELL_M
    assert min(x - column, y - row, column + columns - x, row + rows - y) < 2.0
    assert way[-1] @ (c, s) > 25.0 and (way @ (c, s)).min() < -1.0


def test_a_goal_tens_of_kilometres_away_is_still_a_direction() -> None:
    goal = (60_000.0, 30_000.0)
    map_ = map_with(EMPTY, CELL_M, target=goal)
    way = computed(map_, goal).way(0.0, 0.0, 5.0, 0.0)
    assert math.atan2(*way[-1][::-1]) == pytest.approx(math.atan2(1, 2), abs=0.1)


def test_ways_through_where_the_base_failed_are_longer_and_through_elsewhere_are_not() -> None:
    map_ = map_with(EMPTY, CELL_M)
    map_.avoid(1.5, 0.0, 0.3)
    function = computed(map_, (3.0, 0.0))
    way = function.way(0.0, 0.0, 10.0, 0.0)
    assert np.abs(way[:, 1]).max() > 0.25 and function.value(0, 0) < 3.4
    walls = np.concatenate([wall((1.5, 0.3), (1.5, 7)), wall((1.5, -0.3), (1.5, -7))])
    narrow = map_with(walls, CELL_M)
    free = computed(narrow, (3.0, 0.0)).value(0, 0)
    narrow.avoid(1.5, 0.0, 0.3)
    assert computed(narrow, (3.0, 0.0)).value(0, 0) > free + 3.0


def test_beside_obstacles_ways_are_longer_up_to_the_comfortable_distance() -> None:
    corridor = np.concatenate([wall((-1, 0.35), (4, 0.35)), wall((-1, -0.35), (4, -0.35))])
    wide = np.concatenate([wall((-1, 0.95), (4, 0.95)), wall((-1, -0.95), (4, -0.95))])
    assert computed(map_with(corridor, 0.05), (3.0, 0.0)).value(0, 0) > 4.0
    assert computed(map_with(wide, 0.05), (3.0, 0.0)).value(0, 0) == pytest.approx(3.0, abs=0.1)


def test_a_point_that_was_seen_once_shuts_no_way() -> None:
    map_ = map_with(EMPTY, CELL_M)
    put(map_, [[2.0, 0.0]])
    assert computed(map_, (2.0, 0.05)).outcome == "reached"
    put(map_, [[2.0, 0.0]])
    assert computed(map_, (2.0, 0.05)).outcome == "occupied"


@given(st.integers(0, 10**6))
@settings(max_examples=20)
def test_the_descent_is_a_unit_vector_or_none(seed: int) -> None:
    function = computed(map_with(random_world(seed), CELL_M), (0.0, 0.0), (-4.0, 3.0))
    for x, y in around(seed, 50, 0.0, 12.0):
        length = math.hypot(*function.descent(x, y))
        assert length == pytest.approx(1.0) or length == 0.0
        if function.value(x, y) == math.inf:
            assert length == 0.0


def test_a_way_of_no_length_is_where_it_begins_and_one_from_nowhere_begins_nearby() -> None:
    function = computed(map_with(EMPTY, CELL_M), (0.0, 0.0))
    assert function.way(0.3, 0.2, 0.0, 0.0).tolist() == [[0.3, 0.2]]
    assert function.way(0.0, 0.0, 5.0, 0.0)[-1].tolist() == [0.0, 0.0]
    walled = computed(map_with(wall((2, -1), (2, 1)), CELL_M), (0.0, 0.0), (4.0, 0.0))
    assert walled.value(2.0, 0.0) == math.inf and walled.way(2.0, 0.0, 9.0, 0.15).shape == (0, 2)
    assert walled.way(2.0, 0.0, 9.0, 0.4)[-1].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("far", [math.nan, math.inf, -math.inf, 1e300, -1e12])
def test_far_off_the_map_there_is_nothing(far: float) -> None:
    function = computed(map_with(EMPTY, CELL_M), (0.0, 0.0))
    assert (function.value(far, 0), function.descent(0, far)) == (math.inf, (0, 0))
    assert function.way(0, far, 1.0, 1.0).shape == (0, 2)


def test_on_a_map_without_a_window_no_goal_has_room() -> None:
    assert computed(ObstacleMap(CELL_M), (1.0, 0.0)).outcome == "occupied"


@pytest.mark.parametrize(
    ("cost", "message"),
    [
        ((-0.1, 0.7, 4), "blocked: expected a finite number of at least 0, got -0.1"),
        ((0.2, math.inf, 4), "comfort: expected a finite number of at least 0, got inf"),
        ((0.2, 0.7, math.nan), "weight: expected a finite number of at least 0, got nan"),
        ((0.2, 0.2, 4), "comfort: expected more than blocked, 0.2, got 0.2"),
    ],
)
def test_a_cost_that_is_none_is_refused_by_name(cost, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        NavigationFunction(*cost)


@pytest.mark.parametrize(
    "values", [(math.nan, 0, 0, 0, 0), (0, 2e5, 0, 0, 0), (0, 0, -1, 0, 0), (0, 0, 0, 0, math.inf)]
)
def test_a_goal_that_is_none_is_refused(values) -> None:
    with pytest.raises(ValueError, match=r"^(goal, tolerance, base|tolerance): expected "):
        NavigationFunction(0.2, 0.7, 4).begin(map_with(EMPTY, CELL_M), *values)


@pytest.mark.parametrize("values", [(math.inf, 0), (math.nan, 0), (1, math.inf), (1, math.nan)])
def test_a_way_without_end_is_refused(values) -> None:
    with pytest.raises(ValueError, match=r"^length, reach: expected finite numbers"):
        computed(map_with(EMPTY, CELL_M), (0.0, 0.0)).way(1.0, 1.0, *values)


def test_seeing_free_ground_changes_nothing_but_what_has_gone() -> None:
    map_ = map_with(wall((1, -1), (1, 1)), CELL_M)
    around_it = computed(map_, (3.0, 0.0)).value(0, 0)
    for _ in range(15):
        see(map_, 0.0, 0.0, 5.0)
    assert around_it > 3.3 and computed(map_, (3.0, 0.0)).value(0, 0) == pytest.approx(3.0, abs=0.1)
