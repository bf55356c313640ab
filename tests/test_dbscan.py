# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
from __future__ import annotations

import itertools
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.cluster import DBSCAN

from edgefusion._core import dbscan
from edgefusion.recording.carmen import read_carmen
from edgefusion.types import Scan

Points = npt.NDArray[np.float64]
Labels = npt.NDArray[np.int32]


def by_scikit_learn(points: Points, eps: float, min_points: int) -> Labels:
    labels: Labels = DBSCAN(eps=eps, min_samples=min_points).fit(points).labels_
    return labels


def by_definition(points: list[tuple[float, float]], eps: float, min_points: int) -> list[int]:
    """In exact numbers: every cluster grows from its lowest core point, clusters in rising order."""
    exact = [(Fraction(x), Fraction(y)) for x, y in points]
    square = Fraction(eps) ** 2
    near = [[j for j, q in enumerate(exact) if (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 <= square] for p in exact]
    labels = [-1] * len(points)
    for first in range(len(points)):
        if labels[first] != -1 or len(near[first]) < min_points:
            continue
        label = max(labels) + 1
        labels[first] = label
        open_points = [first]
        while open_points:
            reached = near[open_points.pop()]
            if len(reached) < min_points:
                continue
            joining = [j for j in reached if labels[j] == -1]
            for j in joining:
                labels[j] = label
            open_points += joining
    return labels


def hits(scan: Scan) -> tuple[Points, npt.NDArray[np.float64]]:
    """The points [n, 2] that a scan hit and their ranges [n]."""
    hit = np.isfinite(scan.ranges_m)
    range_m = scan.ranges_m[hit].astype(float)
    angle = scan.angles[hit]
    return np.stack([range_m * np.cos(angle), range_m * np.sin(angle)], axis=1), range_m


def features_of(scan: Scan, features: str) -> Points:
    points, range_m = hits(scan)
    return points if features == "XY" else np.stack([points[:, 1], range_m], axis=1)


@pytest.mark.parametrize("features", ["XY", "Yr"])
@pytest.mark.parametrize("log", ["belgioioso", "csail"])
def test_labels_equal_scikit_learn_on_every_real_scan(shared_data: Path, log: str, features: str) -> None:
    settings = list(itertools.product((0.1, 0.2, 0.3, 0.5), (2, 3, 5)))
    for number, scan in enumerate(read_carmen(shared_data / "carmen" / f"{log}-corrected.log.gz")):
        points = features_of(scan, features)
        for eps, min_points in settings[number % 4 :: 4]:  # scikit-learn takes its time
            expected = by_scikit_learn(points, eps, min_points)
            np.testing.assert_array_equal(
                dbscan(points, eps, min_points),
                expected,
                f"scan {number}, eps {eps}, min_points {min_points}",
            )


def uniform(n: int) -> Points:
    return np.random.default_rng(n).uniform(0, np.sqrt(n), (n, 2))


def clustered(n: int) -> Points:
    random = np.random.default_rng(n)
    centres = random.uniform(0, np.sqrt(n), (20, 2))
    return centres[random.integers(0, 20, n)] + random.normal(0, 0.02 * np.sqrt(n), (n, 2))


@pytest.mark.parametrize("cloud", [uniform, clustered])
@pytest.mark.parametrize("n", [10_000, 100_000])
@pytest.mark.parametrize(("eps", "min_points"), [(0.5, 2), (1.0, 5), (1.5, 10)])
def test_labels_equal_scikit_learn_on_large_clouds(cloud, n: int, eps: float, min_points: int) -> None:
    points = cloud(n)
    np.testing.assert_array_equal(dbscan(points, eps, min_points), by_scikit_learn(points, eps, min_points))


grid_points = st.integers(1, 8).flatmap(
    lambda most: st.lists(st.tuples(st.integers(-most, most), st.integers(-most, most)), max_size=40)
)
radii = st.sampled_from([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 5.0])
minimums = st.integers(1, 8)


def array(points: list[tuple[float, float]]) -> Points:
    return np.array(points, float).reshape(-1, 2)


@given(grid_points, radii, minimums)
@settings(max_examples=400, deadline=None)
def test_labels_are_those_of_the_definition(points, eps: float, min_points: int) -> None:
    assert dbscan(array(points), eps, min_points).tolist() == by_definition(points, eps, min_points)


@given(grid_points.filter(bool), radii, minimums)
@settings(max_examples=100, deadline=None)
def test_labels_equal_scikit_learn_with_ties_and_duplicates(points, eps: float, min_points: int) -> None:
    np.testing.assert_array_equal(
        dbscan(array(points), eps, min_points), by_scikit_learn(array(points), eps, min_points)
    )


@given(grid_points, radii, minimums, st.randoms(use_true_random=False))
@settings(max_examples=200, deadline=None)
def test_the_order_of_the_points_changes_no_core_cluster_and_no_noise(points, eps, min_points, random) -> None:
    order = list(range(len(points)))
    random.shuffle(order)
    labels = dbscan(array(points), eps, min_points)
    shuffled = np.empty_like(labels)
    shuffled[order] = dbscan(array(points)[order], eps, min_points)
    np.testing.assert_array_equal(labels == -1, shuffled == -1)
    core = [
        i
        for i, p in enumerate(points)
        if sum((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 <= eps**2 for q in points) >= min_points
    ]
    renamed = {(labels[i], shuffled[i]) for i in core}
    assert len(renamed) == len({a for a, _ in renamed}) == len({b for _, b in renamed})


@given(grid_points, radii, minimums, st.sampled_from([-1060, -997, -300, 300, 997, 1015]))
@settings(max_examples=200, deadline=None)
def test_scale_does_not_matter_up_to_the_ends_of_the_doubles(points, eps, min_points, exponent) -> None:
    scaled = np.ldexp(array(points), exponent)
    np.testing.assert_array_equal(
        dbscan(scaled, float(np.ldexp(eps, exponent)), min_points), dbscan(array(points), eps, min_points)
    )


extremes = st.sampled_from([0.0, 1.0, -1.0, 1e300, -1e300, 1.1e300, 1e-300, 2e-300, -1e-300, 1e150, 5e-324])


@given(
    st.lists(st.tuples(extremes, extremes), max_size=12),
    st.sampled_from([1.5e-300, 0.5, 1.5, 1.5e150, 0.15e300, 1.5e300]),  # far from a tie, which rounding decides
    st.integers(1, 4),
)
@settings(max_examples=400, deadline=None)
def test_squares_that_overflow_or_vanish_mislead_nobody(points, eps: float, min_points: int) -> None:
    assert dbscan(array(points), eps, min_points).tolist() == by_definition(points, eps, min_points)


@given(grid_points.filter(bool), radii, minimums)
@settings(max_examples=100, deadline=None)
def test_labels_are_those_of_scikit_learns_k_d_tree_whatever_rounding_does_to_a_tie(
    points, eps: float, min_points: int
) -> None:
    tenths = array(points) / 10  # 0.1 + 0.2 is not 0.3
    expected = DBSCAN(eps=eps / 10, min_samples=min_points, algorithm="kd_tree", leaf_size=1).fit(tenths).labels_
    np.testing.assert_array_equal(dbscan(tenths, eps / 10, min_points), expected)


def test_no_points_have_no_labels() -> None:
    labels = dbscan(np.empty((0, 2)), 1.0, 1)
    assert labels.dtype == np.int32 and labels.shape == (0,)


@pytest.mark.parametrize("min_points", [5, 50_000, 100_000, 100_001])
def test_many_equal_points_are_one_cluster_or_noise(min_points: int) -> None:
    labels = dbscan(np.full((100_000, 2), 3.0), 0.3, min_points)
    assert (labels == (0 if min_points <= 100_000 else -1)).all()


def test_a_crowd_within_one_eps_is_one_cluster() -> None:
    points = np.random.default_rng(0).uniform(0, 0.7, (200_000, 2))
    assert (dbscan(points, 1.0, 5) == 0).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", [0, 1])
def test_a_coordinate_that_is_not_finite_is_refused_by_row(value: float, column: int) -> None:
    points = np.zeros((9, 2))
    points[7, column] = value
    with pytest.raises(ValueError, match=rf"^points: expected finite coordinates, got \(.*{value}.*\) in row 7$"):
        dbscan(points, 1.0, 2)


@pytest.mark.parametrize("eps", [0.0, -0.5, np.nan, np.inf])
def test_an_eps_that_is_no_distance_is_refused(eps: float) -> None:
    with pytest.raises(ValueError, match=r"^eps: expected a finite number above 0, got "):
        dbscan(np.zeros((1, 2)), eps, 2)


@pytest.mark.parametrize("min_points", [0, -3])
def test_less_than_one_point_is_refused(min_points: int) -> None:
    with pytest.raises(ValueError, match=f"^min_points: expected at least 1, got {min_points}$"):
        dbscan(np.zeros((1, 2)), 1.0, min_points)


@pytest.mark.parametrize("shape", [(4,), (4, 3), (2, 2, 2)])
def test_points_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"^points: expected shape \[n, 2\], got "):
        dbscan(np.zeros(shape), 1.0, 2)


@pytest.mark.parametrize("type", [np.float32, np.float16, np.int64, np.uint8, ">f8"])
def test_points_may_be_of_any_real_type(type) -> None:
    points = np.array([[0, 0], [1, 0], [9, 9]], type)
    assert dbscan(points, 1.0, 2).tolist() == dbscan(points.tolist(), 1.0, 2).tolist() == [0, 0, -1]


@pytest.mark.parametrize(
    ("points", "came"),
    [
        ([["1", "2"]], "<U1"),
        ([[1j, 2]], "complex128"),
        ([[True, False]], "bool"),
        ([[None, 2]], "object"),
    ],
)
def test_points_that_are_no_real_numbers_are_refused_by_type(points, came: str) -> None:
    with pytest.raises(ValueError, match=f"^points: expected real numbers, got {came}$"):
        dbscan(points, 1.0, 2)


def test_rows_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^points: expected an array of numbers, got list$"):
        dbscan([[1.0, 2.0], [3.0]], 1.0, 2)
