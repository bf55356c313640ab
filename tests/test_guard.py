# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The guard against a simulation in fine steps, with the exact distance from the hull."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion._core import Guard, ObstacleMap, followed
from navigation_scenes import NONE, P3DX, distance, insert, lines_gap, map_with, p3dx, put, see, wall

RAMPS = (0.3, math.radians(100))
REST = (0.0, 0.0, 0.0, 0.0, 0.0)
STRIDE_M = 0.03
"""Between two poses that the guard tries no corner moves farther: half of it may be missed, and a little rounding."""
TOLERANCE_M = STRIDE_M / 2 + 0.003
MARGIN_M = 0.05

SPEEDS, TURNS = st.floats(-0.6, 0.6), st.floats(-1.2, 1.2)
PLACES = st.lists(st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2)), min_size=1, max_size=6)
HOLDS = st.floats(0, 0.8)


@pytest.fixture(scope="module")
def seen_ground() -> ObstacleMap:
    """All of it is seen and free."""
    return map_with(np.zeros((0, 2)), seen_m=4.0)


def guard_among(map_, moving=NONE, base=(0.0, 0.0), reach_m=4.0):
    guard = Guard(p3dx(), *RAMPS)
    guard.look(map_, *base, reach_m, moving)
    return guard


def standing(points):
    points = np.asarray(points, float).reshape(-1, 2)
    return np.hstack([points, np.zeros_like(points)])


def ramped(speed, command, ramp, times):
    return speed + np.clip(command - speed, -ramp * times, ramp * times)


def speeds_along(speed, command, ramp, hold_s, times):
    """What the drive makes of a command that is held for some time, and then of a stop."""
    last = ramped(speed, command, ramp, hold_s)
    return np.where(times < hold_s, ramped(speed, command, ramp, times), ramped(last, 0.0, ramp, times - hold_s))


def simulated(motion, v, w, hold_s, dt_s=0.002):
    """Times [n] and poses [n, 3] until the base stands."""
    x, y, theta, v0, w0 = motion
    braking_s = [abs(ramped(*speeds, ramp, hold_s)) / ramp for speeds, ramp in zip(((v0, v), (w0, w)), RAMPS)]
    times = np.arange(0, hold_s + max(braking_s) + dt_s, dt_s)
    middles = times[:-1] + dt_s / 2
    speed = speeds_along(v0, v, RAMPS[0], hold_s, middles)
    headings = theta + np.concatenate([[0.0], np.cumsum(speeds_along(w0, w, RAMPS[1], hold_s, middles) * dt_s)])
    along = (headings[:-1] + headings[1:]) / 2
    xs = x + np.concatenate([[0.0], np.cumsum(speed * np.cos(along) * dt_s)])
    ys = y + np.concatenate([[0.0], np.cumsum(speed * np.sin(along) * dt_s)])
    return times, np.stack([xs, ys, headings], axis=1)


def simulated_gaps(motion, v, w, hold_s, moving):
    """The smallest true distance on the way, and the smallest as the guard measures it, at most as large."""
    times, poses = simulated(motion, v, w, hold_s)
    points = moving[None, :, :2] + times[:, None, None] * moving[None, :, 2:]
    return distance(P3DX, poses, points).min(), lines_gap(P3DX, poses, points).min()


def gap_at(motion, moving):
    return lines_gap(P3DX, motion[:3], moving[:, :2]).min()


@settings(max_examples=300)
@given(PLACES, SPEEDS, TURNS, SPEEDS, TURNS, HOLDS)
def test_it_never_says_free_where_a_fine_simulation_touches(seen_ground, places, v0, w0, v, w, hold_s) -> None:
    motion, moving = (0.0, 0.0, 0.0, v0, w0), standing(places)
    free = guard_among(seen_ground, moving).free(seen_ground, motion, v, w, hold_s, MARGIN_M)
    true_m, lines_m = simulated_gaps(motion, v, w, hold_s, moving)
    if gap_at(motion, moving) >= MARGIN_M:
        if free:
            assert true_m > MARGIN_M - TOLERANCE_M
        else:
            assert lines_m < MARGIN_M + 0.003


@settings(max_examples=200)
@given(
    st.lists(st.tuples(*[st.floats(-2, 2)] * 2, *[st.floats(-1.5, 1.5)] * 2), min_size=1, max_size=4),
    SPEEDS,
    TURNS,
    HOLDS,
)
def test_so_it_is_with_what_moves(seen_ground, movers, v, w, hold_s) -> None:
    motion, moving = (0.0, 0.0, 0.3, 0.2, 0.0), np.array(movers)
    if gap_at(motion, moving) < MARGIN_M:
        return
    free = guard_among(seen_ground, moving).free(seen_ground, motion, v, w, hold_s, MARGIN_M)
    true_m, _ = simulated_gaps(motion, v, w, hold_s, moving)
    way_of_points_m = 0.05 * np.hypot(*moving[:, 2:].T).max() / 2
    if free:
        assert true_m > MARGIN_M - TOLERANCE_M - way_of_points_m


@given(st.floats(-math.pi, math.pi), st.floats(-50, 50), st.floats(-50, 50))
def test_it_is_the_same_wherever_the_base_stands_and_looks(angle: float, x: float, y: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    for ahead_m, free in ((0.50, True), (0.30, False)):
        map_ = map_with(np.zeros((0, 2)), base=(x, y), target=(x, y), seen_m=2.0)
        put(map_, [[x + ahead_m * c, y + ahead_m * s]])
        guard = guard_among(map_, base=(x, y))
        assert guard.free(map_, (x, y, angle, 0.2, 0.0), 0.2, 0.0, 0.1, MARGIN_M) == free


def test_the_distance_to_stop_in_grows_with_the_square_of_the_speed(seen_ground) -> None:
    def room_m(v):
        for room in np.arange(0.0, 1.0, 0.005):
            guard = guard_among(seen_ground, standing([[0.210 + room, 0.0]]))
            if guard.free(seen_ground, (0, 0, 0, v, 0), v, 0.0, 0.0, 0.0):
                return room
        return math.inf

    for v in (0.1, 0.2, 0.4, 0.6):
        assert room_m(v) == pytest.approx(v * v / (2 * RAMPS[0]), abs=0.006)


def test_the_tail_that_swings_is_watched(seen_ground) -> None:
    beside_the_tail = standing([[-0.28, 0.26]])
    guard = guard_among(seen_ground, beside_the_tail)
    assert guard.free(seen_ground, REST, 0.2, 0.0, 0.3, 0.02)
    assert not guard.free(seen_ground, REST, 0.0, -1.0, 0.5, 0.02)
    assert guard.free(seen_ground, REST, 0.0, 1.0, 0.5, 0.02)


def test_a_standing_base_may_stand_wherever_it_is(seen_ground) -> None:
    for x in (0.5, 0.22, 0.19, 0.0):
        assert guard_among(seen_ground, standing([[x, 0.0]])).free(seen_ground, REST, 0.0, 0.0, 1.0, MARGIN_M)


def test_who_runs_into_a_standing_base_makes_standing_no_more_free_than_driving_away(seen_ground) -> None:
    coming = np.array([[0.6, 0.0, -1.0, 0.0]])
    guard = guard_among(seen_ground, coming)
    assert not guard.free(seen_ground, REST, 0.0, 0.0, 1.0, MARGIN_M)
    assert guard.free(seen_ground, REST, 0.0, 0.0, 0.1, MARGIN_M)
    passing = np.array([[0.6, -3.0, 0.0, 1.0]])
    assert guard_among(seen_ground, passing).free(seen_ground, REST, 0.2, 0.0, 0.5, MARGIN_M)
    assert guard_among(seen_ground, standing([[2.0, 0.0]])).free(seen_ground, REST, 0.2, 0.0, 0.5, MARGIN_M)


def test_it_waits_for_who_comes_while_it_lingers_and_knows_whether_anyone_does(seen_ground) -> None:
    coming = guard_among(seen_ground, np.array([[1.5, 0.0, -1.0, 0.0]]))
    assert coming.stirs and not guard_among(seen_ground, standing([[1.5, 0.0]])).stirs
    assert coming.free(seen_ground, REST, 0.0, 0.0, 0.1, MARGIN_M, 0.2)
    assert not coming.free(seen_ground, REST, 0.0, 0.0, 0.1, MARGIN_M, 2.0)


def test_a_base_within_the_margin_may_go_away_but_hardly_nearer(seen_ground) -> None:
    guard = guard_among(seen_ground, standing([[0.210 + 0.03, 0.0]]))
    assert guard.gap((0, 0, 0)) == pytest.approx(0.03)
    assert guard.free(seen_ground, REST, -0.2, 0.0, 0.2, MARGIN_M)
    assert not guard.free(seen_ground, REST, 0.1, 0.0, 0.2, MARGIN_M)
    touching = guard_among(seen_ground, standing([[0.205, 0.0]]))
    assert touching.free(seen_ground, REST, -0.2, 0.0, 0.2, MARGIN_M)
    assert not touching.free(seen_ground, REST, 0.02, 0.0, 0.1, MARGIN_M)


def test_coming_nearer_again_and_again_ends_before_it_touches(seen_ground) -> None:
    x, wall_m = 0.0, 0.210 + 0.04
    for _ in range(200):
        guard = guard_among(seen_ground, standing([[wall_m, 0.0]]))
        motion = (x, 0.0, 0.0, 0.0, 0.0)
        if guard.free(seen_ground, motion, 0.02, 0.0, 0.1, MARGIN_M):
            x = followed(motion, 0.02, 0.0, *RAMPS, 0.1)[0]
    assert x < 0.04 - 0.25 * MARGIN_M + 1e-9


def half_seen(ahead: bool):
    """Beams have come through what is ahead of x = 0, or behind."""
    map_ = map_with(np.zeros((0, 2)))
    for y in np.arange(-0.5, 0.5, 0.025):
        map_.insert([[0.0, y, 0.0 if ahead else math.pi]], [np.inf], 0.0, 0.1, 0.0, 4.0, 0)
    return map_


@pytest.mark.parametrize("ahead", [True, False])
def test_it_drives_over_seen_ground_alone_ahead_and_back(ahead: bool) -> None:
    map_ = half_seen(ahead)
    guard = guard_among(map_)
    assert guard.free(map_, REST, 0.2, 0.0, 0.3, MARGIN_M) == ahead
    assert guard.free(map_, REST, -0.2, 0.0, 0.3, MARGIN_M) != ahead
    assert guard.free(map_, REST, 0.0, 0.5, 0.3, MARGIN_M)


def test_it_goes_back_over_ground_that_it_stood_on_and_no_farther() -> None:
    map_ = half_seen(True)
    for x in np.arange(0.0, 1.0, 0.02):
        map_.stand(p3dx(), (x, 0.0, 0.0), 0.02)
    guard = guard_among(map_, base=(1.0, 0.0))
    assert guard.free(map_, (1.0, 0.0, 0.0, 0.0, 0.0), -0.3, 0.0, 2.0, MARGIN_M)
    assert not guard.free(map_, (0.1, 0.0, 0.0, 0.0, 0.0), -0.3, 0.0, 2.0, MARGIN_M)


@given(PLACES, st.floats(-math.pi, math.pi))
def test_fitting_and_gap_are_those_of_the_hull_to_the_points_of_the_map(places, theta: float) -> None:
    map_ = map_with(np.zeros((0, 2)), seen_m=3.0)
    put(map_, np.round(places, 1))  # so far apart that they are different things
    points = map_.points()
    guard, pose = guard_among(map_), (0.1, -0.2, theta)
    gap_m = lines_gap(P3DX, pose, points).min()
    assert guard.gap(pose) == pytest.approx(gap_m, abs=1e-9)
    assert guard.fits(pose, gap_m - 1e-6) and not guard.fits(pose, distance(P3DX, pose, points).min() + 1e-6)


def test_the_other_side_of_what_is_seen_is_kept_clear_of_too() -> None:
    map_ = map_with(np.zeros((0, 2)))
    see(map_, radius_m=0.75)
    put(map_, wall((0.6, -0.2), (0.6, 0.2)))
    guard = guard_among(map_)
    assert guard.gap((1.3, 0.0, 0.0)) < 1.3 - 0.301 - 0.6 - 0.04
    assert guard.gap((0.0, 0.0, 0.0)) == pytest.approx(0.39, abs=1e-6)


def test_beyond_its_reach_and_with_nothing_around_there_is_no_gap(seen_ground) -> None:
    assert guard_among(seen_ground).gap((0, 0, 0)) == math.inf
    map_ = map_with([[3.0, 0.0]], seen_m=4.0)
    assert guard_among(map_, reach_m=1.0).gap((0, 0, 0)) == math.inf
    assert guard_among(map_, reach_m=3.5).gap((0, 0, 0)) == pytest.approx(2.79, abs=1e-6)
    assert guard_among(seen_ground).fits((1e9, 0, 0), 0.1)


@given(SPEEDS, TURNS, SPEEDS, TURNS, st.floats(0, 2))
def test_what_follows_a_command_is_where_the_simulation_is(v0, w0, v, w, duration_s) -> None:
    x, y, theta, speed, rate = followed((0.5, -0.5, 1.0, v0, w0), v, w, *RAMPS, duration_s)
    _, poses = simulated((0.5, -0.5, 1.0, v0, w0), v, w, duration_s)
    at = round(duration_s / 0.002)
    np.testing.assert_allclose((x, y, theta), poses[at], atol=6e-3)
    assert speed == pytest.approx(v0 + np.clip(v - v0, -RAMPS[0] * duration_s, RAMPS[0] * duration_s), abs=1e-6)
    assert rate == pytest.approx(w0 + np.clip(w - w0, -RAMPS[1] * duration_s, RAMPS[1] * duration_s), abs=1e-6)


def test_after_no_time_nothing_has_changed() -> None:
    assert followed((1, 2, 3, 0.4, 0.5), 0.0, 0.0, *RAMPS, 0.0) == (1, 2, 3, 0.4, 0.5)


NOT_FINITE = (math.nan, math.inf, -math.inf)


@pytest.mark.parametrize("bad", NOT_FINITE)
def test_numbers_that_are_not_finite_are_refused(seen_ground, bad: float) -> None:
    guard = guard_among(seen_ground)
    for command in ((bad, 0, 0.1, 0.1), (0, bad, 0.1, 0.1), (0, 0, bad, 0.1), (0, 0, 0.1, bad), (0, 0, 0.1, 0.1, bad)):
        with pytest.raises(ValueError, match=r"expected (a )?finite number"):
            guard.free(seen_ground, REST, *command)
    with pytest.raises(ValueError, match=r"^motion: expected finite numbers, got .* at index 3"):
        guard.free(seen_ground, (0, 0, 0, bad, 0), 0, 0, 0.1, 0.1)
    with pytest.raises(ValueError, match=r"^pose: expected finite numbers"):
        guard.gap((0, bad, 0))
    with pytest.raises(ValueError, match=r"^moving: expected finite numbers"):
        guard.look(seen_ground, 0, 0, 1, [[0, 0, bad, 0]])
    with pytest.raises(ValueError, match=r"^x, y, reach: expected finite numbers"):
        guard.look(seen_ground, 0, 0, bad, NONE)
    with pytest.raises(ValueError, match=r"^duration: expected a finite number of at least 0"):
        followed(REST, 0, 0, *RAMPS, bad)


def test_what_is_no_guard_is_refused_by_name(seen_ground) -> None:
    with pytest.raises(ValueError, match=r"^acceleration: expected a finite number above 0, got 0$"):
        Guard(p3dx(), 0.0, 1.0)
    with pytest.raises(ValueError, match=r"^yaw_acceleration: expected a finite number above 0, got nan$"):
        Guard(p3dx(), 1.0, math.nan)
    with pytest.raises(ValueError, match=r"^yaw_acceleration: expected a finite number above 0, got -1$"):
        followed(REST, 0, 0, 1.0, -1.0, 1.0)
    with pytest.raises(ValueError, match=r"^hold: expected a finite number of at least 0, got -0.1$"):
        guard_among(seen_ground).free(seen_ground, REST, 0, 0, -0.1, 0.1)
    with pytest.raises(ValueError, match=r"^moving: expected shape \[n, 4\], got \[1, 2\]$"):
        guard_among(seen_ground, [[1.0, 2.0]])


def test_one_thing_too_near_loosens_nothing_else() -> None:
    flank = [[0.0, -0.15]]  # six centimetres inside the hull
    front = wall((0.30, -0.4), (0.30, 0.4))
    map_ = map_with(np.concatenate([flank, front]), seen_m=2.0)
    guard = guard_among(map_)
    assert not guard.free(map_, (0.0, 0.0, 0.0, 0.2, 0.0), 0.2, 0.0, 0.1, 0.02)


def test_the_noise_of_a_surface_in_the_next_cell_is_no_obstacle_but_what_comes_new_soon_is() -> None:
    map_ = map_with(np.zeros((0, 2)), seen_m=1.3)
    shot = dict(angle_min=0.0, angle_increment=0.01, range_min_m=0.0, range_max_m=8.0)
    for i in range(60):
        map_.insert([[0, 0, 0]], np.array([1.01], np.float32), stamp_ns=i * 50_000_000, **shot)
    map_.insert([[0, 0, 0]], np.array([0.99], np.float32), stamp_ns=4_000_000_000, **shot)
    guard = guard_among(map_)
    assert guard.gap((0, 0, 0)) == pytest.approx(1.01 - 0.21, abs=1e-3)
    for i in range(12):
        map_.insert([[0, 0, 0]], np.array([0.99], np.float32), stamp_ns=4_100_000_000 + i * 50_000_000, **shot)
    assert guard_among(map_).gap((0, 0, 0)) == pytest.approx(0.99 - 0.21, abs=0.01)


@given(st.sampled_from((1, -1)), st.floats(-0.05, 0.05), st.floats(0.3, 0.65), st.floats(-0.2, 0.2))
def test_no_corner_of_a_wall_ahead_hides_behind_the_mean_of_its_cell(
    side: int, end_m: float, far_m: float, aside_m: float
) -> None:
    """The wall ends at its left, where the sweep comes last, or at its right."""
    angles = np.arange(-90, 90.1, 0.5) * math.pi / 180
    ahead = np.cos(angles) > 0.1
    ranges = np.full(len(angles), np.inf)
    ranges[ahead] = far_m / np.cos(angles[ahead])
    ranges[side * np.sin(angles) * np.where(ahead, ranges, 0) > end_m] = np.inf  # the wall ends there
    map_ = map_with(np.zeros((0, 2)), seen_m=2.0)
    for i in range(10):
        insert(map_, ranges, angle_min=-math.pi / 2, step=math.radians(0.5), at_s=0.05 * i)
    pose = (far_m - 0.21 - 0.02, side * (end_m + 0.2125 - 0.03 + aside_m), 0.0)  # 2 cm from the wall, or past it
    true_m = distance(P3DX, pose, wall((far_m, -2.0 * side), (far_m, side * end_m), 0.001)).min()
    assert guard_among(map_, base=(0.3, 0.0)).gap(pose) == pytest.approx(true_m, abs=0.01)
