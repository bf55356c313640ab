# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Ray casting: the nearest segment of every beam, whichever way the beams turn and however the walls lie."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import raycast

ORIGIN = (0.0, 0.0, 0.0)
WALL = np.array([[2.0, -50.0, 2.0, 50.0]])
SQUARE = np.array([[-2, -2, 2, -2], [2, -2, 2, 2], [2, 2, -2, 2], [-2, 2, -2, -2]], float)


def brute_force(segments, pose, angle_min, angle_increment, n, range_max):
    """Every beam against every segment."""
    angles = [pose[2] + (angle_min + i * angle_increment) for i in range(n)]
    beam = np.array([[math.cos(angle), math.sin(angle)] for angle in angles]).reshape(n, 1, 2)
    a, b = segments[:, :2] - pose[:2], segments[:, 2:] - pose[:2]
    left_a, left_b = (beam[..., 0] * end[:, 1] - beam[..., 1] * end[:, 0] for end in (a, b))
    along_a, along_b = (beam[..., 0] * end[:, 0] + beam[..., 1] * end[:, 1] for end in (a, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        range_m = along_a + (along_b - along_a) * (left_a / (left_a - left_b))
    lying = np.where((along_a > 0) != (along_b > 0), 0.0, np.minimum(along_a, along_b))
    range_m = np.where(left_a == left_b, lying, range_m)
    between = (np.sign(left_a) * np.sign(left_b) <= 0) & (a != b).any(axis=1)
    range_m = np.where(between & (range_m >= 0) & (range_m <= range_max), range_m, np.inf)
    range_m = np.hstack([range_m, np.full((n, 1), np.inf)])
    nearest = range_m.min(axis=1)
    return nearest, np.where(np.isfinite(nearest), range_m.argmin(axis=1), -1)


EIGHTHS = st.integers(-40, 40).map(lambda k: k / 8)
ANGLES = st.one_of(st.floats(-10, 10), st.integers(-16, 16).map(lambda k: k * math.pi / 8))


@given(
    segments=st.lists(st.tuples(EIGHTHS, EIGHTHS, EIGHTHS, EIGHTHS), max_size=12),
    pose=st.tuples(EIGHTHS, EIGHTHS, ANGLES),
    angle_min=ANGLES,
    angle_increment=ANGLES.filter(bool),
    n=st.integers(0, 50),
    range_max=st.floats(0.1, 20),
)
def test_it_equals_every_beam_against_every_segment(segments, pose, angle_min, angle_increment, n, range_max) -> None:
    walls = np.array(segments, float).reshape(-1, 4)
    ranges, hits = raycast(walls, pose, angle_min, angle_increment, n, range_max)
    expected_ranges, expected_hits = brute_force(walls, pose, angle_min, angle_increment, n, range_max)
    np.testing.assert_array_equal(ranges, expected_ranges)
    np.testing.assert_array_equal(hits, expected_hits)
    assert (ranges.dtype, hits.dtype) == (np.float64, np.int32)


@given(seed=st.integers(0, 999), n=st.integers(1, 400), turns=st.floats(0.01, 3), sign=st.sampled_from((-1, 1)))
def test_it_equals_brute_force_among_many_short_segments(seed: int, n: int, turns: float, sign: int) -> None:
    rng = np.random.default_rng(seed)
    start = rng.uniform(-8, 8, (300, 2))
    walls = np.hstack([start, start + rng.normal(0, 0.3, (300, 2))])
    sweep = (rng.uniform(-4, 4), sign * turns * 2 * math.pi / n, n, 7.0)
    pose = rng.uniform(-3, 3, 3)
    for got, expected in zip(raycast(walls, pose, *sweep), brute_force(walls, pose, *sweep)):
        np.testing.assert_array_equal(got, expected)


@given(EIGHTHS, EIGHTHS, st.integers(3, 40), st.floats(0, 7))
def test_nothing_escapes_from_a_closed_outline(x: float, y: float, corners: int, turn: float) -> None:
    angles = turn + np.arange(corners + 1) % corners * 2 * np.pi / corners
    outline = np.stack([x + 3 * np.cos(angles), y + 3 * np.sin(angles)], axis=1)
    walls = np.hstack([outline[:-1], outline[1:]])
    through_corners = raycast(walls, (x, y, 0), turn, 2 * math.pi / corners, corners, 10)[0]
    np.testing.assert_allclose(through_corners, 3, rtol=1e-12)
    inner = 3 * math.cos(math.pi / corners)
    ranges, hits = raycast(walls, (x, y, 0), turn, 0.01, 700, 10)
    assert ((ranges >= inner - 1e-12) & (ranges <= 3 + 1e-12)).all()
    assert set(hits) == set(range(corners))


def test_a_wall_is_as_far_as_geometry_says() -> None:
    angles = np.radians(np.linspace(-60, 60, 241))
    ranges, hits = raycast(WALL, ORIGIN, -math.pi / 3, math.radians(0.5), 241, 100)
    np.testing.assert_allclose(ranges, 2 / np.cos(angles), rtol=1e-12)
    assert (hits == 0).all()


def test_beams_count_the_other_way_with_a_negative_increment() -> None:
    forth = raycast(SQUARE, (0.3, 0.2, 0.1), -math.pi / 2, math.pi / 360, 361, 10)
    back = raycast(SQUARE, (0.3, 0.2, 0.1), math.pi / 2, -math.pi / 360, 361, 10)
    np.testing.assert_allclose(back[0][::-1], forth[0], rtol=1e-12)


def test_a_second_turn_sees_what_the_first_saw() -> None:
    ranges, hits = raycast(SQUARE, (0.3, 0.2, 0.1), 1.0, 2 * math.pi / 90, 180, 10)
    np.testing.assert_allclose(ranges[:90], ranges[90:], rtol=1e-9)
    assert np.isfinite(ranges).all() and set(hits) == {0, 1, 2, 3}


def test_what_is_beyond_range_max_or_behind_is_not_hit() -> None:
    for pose, range_max in ((ORIGIN, 1.9), ((2.5, 0, 0), 10)):
        ranges, hits = raycast(WALL, pose, -0.5, 0.1, 11, range_max)
        assert np.isposinf(ranges).all() and (hits == -1).all()


@pytest.mark.parametrize("wall", [[-1, 0, 1, 0], [0, 0, 1, 0], [1, 0, 0, 0]])
def test_a_laser_that_stands_on_a_wall_reads_0(wall) -> None:
    assert raycast([wall], ORIGIN, 0.1, 0.5, 13, 10)[0].tolist() == [0] * 13


def test_no_segments_and_no_beams_are_fine() -> None:
    ranges, hits = raycast(np.empty((0, 4)), ORIGIN, 0, 0.1, 5, 10)
    assert np.isposinf(ranges).all() and hits.tolist() == [-1] * 5
    assert [len(answer) for answer in raycast(WALL, ORIGIN, 0, 0.1, 0, 10)] == [0, 0]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"segments": [[0, 0, math.nan, 1]]}, "segments: expected finite numbers, got nan at index 2"),
        ({"segments": [[0, 0, 1]]}, r"segments: expected shape \[n, 4\], got \[1, 3\]"),
        ({"pose": [0, 0]}, r"pose: expected shape \[3\], got \[2\]"),
        ({"pose": [0, 0, -math.inf]}, "pose: expected finite numbers, got -inf at index 2"),
        ({"angle_min": math.inf}, "angle_min: expected a finite number, got inf"),
        ({"angle_increment": 0}, "angle_increment: expected a finite number other than 0, got 0"),
        ({"angle_increment": math.nan}, "angle_increment: expected a finite number other than 0, got nan"),
        ({"angle_increment": 1.7e308}, "angle_increment: expected finite angles of all beams, got inf"),
        ({"n": -1}, "n: expected at least 0, got -1"),
        ({"range_max": 0}, "range_max: expected a finite number above 0, got 0"),
        ({"range_max": math.nan}, "range_max: expected a finite number above 0, got nan"),
    ],
)
def test_what_makes_no_sweep_is_refused_by_name(changed: dict, message: str) -> None:
    good = {"segments": WALL, "pose": ORIGIN, "angle_min": 0, "angle_increment": 0.1, "n": 3, "range_max": 10}
    with pytest.raises(ValueError, match=f"^{message}$"):
        raycast(**{**good, **changed})
