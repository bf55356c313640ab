# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The nearest surface: less biased than the paper's min(r), with a sigma that holds."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.distance import study
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import nearest_range
from edgefusion.config import PerceptionConfig
from edgefusion.perception.distance import nearest_surface
from edgefusion.types import Cluster, Scan

SIGMA = 0.01
STEP = np.radians(0.5)


def cylinder(distance_m: float, radius_m: float, rng: np.random.Generator) -> np.ndarray:
    """Noisy ranges of the beams that hit a cylinder straight ahead."""
    angles = STEP * np.arange(-60, 61)
    centre = distance_m + radius_m
    inside = radius_m**2 - (centre * np.sin(angles)) ** 2
    angles, inside = angles[inside > 0], inside[inside > 0]
    return centre * np.cos(angles) - np.sqrt(inside) + rng.normal(0, SIGMA, len(angles))


def test_the_corrected_range_is_less_biased_and_its_sigma_holds() -> None:
    rng = np.random.default_rng(5)
    truths = rng.uniform(0.5, 5, 600)
    scans = [cylinder(truth, radius, rng) for truth, radius in zip(truths, rng.uniform(0.05, 0.4, 600))]
    answers = np.array([nearest_range(ranges, SIGMA)[:2] for ranges in scans])
    minima = np.array([ranges.min() for ranges in scans])
    assert abs((answers[:, 0] - truths).mean()) < 0.003 < abs((minima - truths).mean())
    assert np.percentile(np.abs(answers[:, 0] - truths), 95) < 0.03
    assert (np.abs(answers[:, 0] - truths) < 2 * answers[:, 1]).mean() > 0.95
    assert answers[:, 1].mean() < 1.2 * SIGMA  # which a sigma that is merely large would not be


@pytest.mark.parametrize(("mixed", "least", "most"), [(True, 0.93, 0.97), (False, 0.95, 0.995)])
def test_faces_boxes_and_cylinders_are_within_two_sigma_as_often_as_they_should(mixed, least, most) -> None:
    ours = next(row for row in study(mixed, 1500, seed=3) if row["name"] == "edgefusion")
    assert least < ours["within_2_sigma"] < most
    assert ours["p95_mm"] < 30


@given(st.lists(st.floats(0.1, 50), min_size=1, max_size=60), st.floats(1e-4, 0.1))
def test_any_ranges_have_a_nearest_surface_about_the_minimum(ranges: list[float], sigma: float) -> None:
    range_m, sigma_m, beam = nearest_range(ranges, sigma)
    assert sigma_m > 0
    assert 0 <= beam < len(ranges)
    # Never nearer than half a step to the neighbour before the minimum, never farther than its bias can be.
    assert min(ranges) - max(ranges) <= range_m <= min(ranges) + 6 * sigma


@given(st.lists(st.floats(0.5, 20), min_size=1, max_size=40), st.floats(-0.4, 10))
def test_a_farther_object_is_farther_by_as_much(ranges: list[float], shift: float) -> None:
    here = nearest_range(ranges, SIGMA)
    there = nearest_range([r + shift for r in ranges], SIGMA)
    assert there[0] - here[0] == pytest.approx(shift, abs=1e-6)
    assert there[1] == pytest.approx(here[1], rel=1e-4)


def test_the_papers_minimum_is_a_setting() -> None:
    scan = Scan(0, np.array([2.0, 1.98, 2.01], np.float32), -STEP, STEP)
    cluster = Cluster(np.arange(3), 1.98, 0.0, 0.03)
    surface = nearest_surface(scan, cluster, PerceptionConfig(distance="minimum"))
    assert surface.range_m == pytest.approx(1.98)
    assert surface.bearing == pytest.approx(0.0)
    assert nearest_surface(scan, cluster, PerceptionConfig()).range_m > 1.98


@pytest.mark.parametrize(
    ("ranges", "sigma", "message"),
    [
        ([], SIGMA, "ranges_m: expected at least one range, got none"),
        ([1.0, np.nan, 1.0], SIGMA, "ranges_m: expected finite numbers, got nan at index 1"),
        ([1.0, 1.0, np.inf], SIGMA, "ranges_m: expected finite numbers, got inf at index 2"),
        (np.array([1, -np.inf], np.float32), SIGMA, "ranges_m: expected finite numbers, got -inf at index 1"),
        ([[1.0]], SIGMA, r"ranges_m: expected shape \[n\], got \[1, 1\]"),
        (["1"], SIGMA, "ranges_m: expected real numbers, got <U1"),
        ([1.0], 0.0, "sigma_m: expected a finite number above 0, got 0"),
        ([1.0], -0.01, "sigma_m: expected a finite number above 0, got -0.01"),
        ([1.0], np.nan, "sigma_m: expected a finite number above 0, got nan"),
        ([1.0], np.inf, "sigma_m: expected a finite number above 0, got inf"),
    ],
)
def test_ranges_and_noise_that_cannot_be_are_refused_by_name(ranges, sigma: float, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        nearest_range(ranges, sigma)
