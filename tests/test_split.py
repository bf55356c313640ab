# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What touches is parted where something stands before a straight face, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import dbscan, raycast, split_clusters

SIGMA_M, EPS_M, MIN_POINTS = 0.01, 0.3, 3
WALL = [(4.0, -3.0, 4.0, 3.0)]


def block(x: float, y: float, depth: float, width: float, yaw: float = 0.0) -> list[tuple[float, ...]]:
    """The four sides of a box about (x, y), turned by yaw."""
    corners = np.array([[1, -1], [1, 1], [-1, 1], [-1, -1]]) * (depth / 2, width / 2)
    c, s = np.cos(yaw), np.sin(yaw)
    corners = corners @ np.array([[c, s], [-s, c]]) + (x, y)
    return [(*a, *b) for a, b in zip(corners, np.roll(corners, -1, axis=0))]


def drum(x: float, y: float, radius: float) -> list[tuple[float, ...]]:
    angles = np.linspace(0, 2 * np.pi, 33)
    points = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)
    return [(*a, *b) for a, b in zip(points, points[1:])]


def seen(*shapes: list[tuple[float, ...]], seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The points that a noisy laser at the origin sees of these shapes, and whose each is."""
    segments = np.array([segment for shape in shapes for segment in shape])
    owner_of = np.repeat(np.arange(len(shapes)), [len(shape) for shape in shapes])
    ranges_m, hits = raycast(segments, [0, 0, 0], -np.pi / 2, np.radians(0.5), 361, 30)
    angles = np.radians(np.arange(-90, 90.25, 0.5))
    ranges_m = ranges_m + np.random.default_rng(seed).normal(0, SIGMA_M, 361)
    met = hits >= 0
    points = ranges_m[met, None] * np.stack([np.cos(angles[met]), np.sin(angles[met])], axis=1)
    return points, owner_of[hits[met]]


def parted(points: np.ndarray) -> np.ndarray:
    labels = dbscan(points, EPS_M, MIN_POINTS)
    return split_clusters(points, labels, SIGMA_M, EPS_M, MIN_POINTS)


def share_alone(labels: np.ndarray, owners: np.ndarray, owner: int) -> float:
    """The largest share of an owner's points in one cluster that is mostly its own."""
    shares = [
        (owners[labels == label] == owner).sum() / (owners == owner).sum()
        for label in set(labels.tolist()) - {-1}
        if (owners[labels == label] == owner).mean() > 0.8
    ]
    return max(shares, default=0.0)


@pytest.mark.parametrize(
    "thing", [block(3.87, 0.4, 0.24, 0.6), drum(3.86, -0.8, 0.13), block(3.85, 0.0, 0.2, 0.3, 0.4)]
)
def test_what_stands_at_a_wall_becomes_a_cluster_of_its_own(thing) -> None:
    points, owners = seen(WALL, thing)
    labels = parted(points)
    assert share_alone(dbscan(points, EPS_M, MIN_POINTS), owners, 1) == 0  # one cluster with the wall before
    assert share_alone(labels, owners, 1) > 0.75
    assert share_alone(labels, owners, 0) > 0.9  # the wall is one, on both sides of the thing


def test_things_in_the_corner_of_a_room_are_parted_from_both_walls() -> None:
    points, owners = seen([*WALL, (4.0, 1.0, 0.5, 1.0)], block(3.6, 0.65, 0.5, 0.5))
    assert share_alone(parted(points), owners, 1) > 0.7


def test_two_boxes_side_by_side_are_two_where_one_is_deeper() -> None:
    points, owners = seen(block(2.0, 0.3, 0.5, 0.58), block(2.15, -0.3, 0.5, 0.58))
    labels = parted(points)
    assert share_alone(labels, owners, 0) > 0.7
    assert share_alone(labels, owners, 1) > 0.7


@given(
    st.floats(0.6, 5.0), st.floats(-1.0, 1.0), st.floats(0.2, 0.8), st.floats(0.2, 0.8), st.floats(-3.1, 3.1),
    st.booleans(), st.integers(0, 9),
)  # fmt: skip
def test_a_single_convex_thing_stays_whole(distance, bearing, depth, width, yaw, is_round, seed) -> None:
    away = distance + max(depth, width)
    x, y = away * np.cos(bearing), away * np.sin(bearing)
    points, _ = seen(drum(x, y, width / 2) if is_round else block(x, y, depth, width, yaw), seed=seed)
    before = dbscan(points, EPS_M, MIN_POINTS)
    assert len(set(parted(points).tolist())) == len(set(before.tolist()))


@given(st.integers(0, 60), st.integers(0, 2**31))
def test_no_point_changes_sides_between_clusters_that_were_apart(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    points = random.uniform(-3, 3, (n, 2))
    before = random.integers(-1, 4, n) % max(n, 1) if n else np.zeros(0, int)
    after = split_clusters(points, before, SIGMA_M, EPS_M, MIN_POINTS)
    assert (after[before == -1] == -1).all()
    for label in set(after.tolist()) - {-1}:
        assert len(set(before[after == label].tolist())) == 1


def test_the_papers_single_clusters_stay_as_they_are_without_anything_before_a_face() -> None:
    points, _ = seen(WALL)
    labels = dbscan(points, EPS_M, MIN_POINTS)
    assert (split_clusters(points, labels, SIGMA_M, EPS_M, MIN_POINTS) == labels).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": [[0.0, np.nan]]}, "points: expected finite numbers, got nan at index 1"),
        ({"points": [[0.0, 1.0, 2.0]]}, r"points: expected shape \[n, 2\], got \[1, 3\]"),
        ({"labels": np.array([0, 0])}, r"labels: expected shape \[1\], got \[2\]"),
        ({"labels": np.array([0.5])}, "labels: expected integers, got float64"),
        ({"labels": np.array([1])}, "labels: expected -1 to 0, got 1 at index 0"),
        ({"labels": np.array([-2])}, "labels: expected -1 to 0, got -2 at index 0"),
        ({"labels": np.array([2**40])}, "labels: expected -1 to 0, got 2147483647 at index 0"),
        ({"sigma_m": 0.0}, "sigma_m: expected a finite number above 0, got 0"),
        ({"eps": np.inf}, "eps: expected a finite number above 0, got inf"),
        ({"min_points": 0}, "min_points: expected at least 1, got 0"),
    ],
)
def test_bad_input_is_refused_by_name(change, message: str) -> None:
    arguments = {"points": [[1.0, 0.0]], "labels": np.array([0]), "sigma_m": 0.01, "eps": 0.3, "min_points": 3}
    with pytest.raises(ValueError, match=message):
        split_clusters(**{**arguments, **change})
