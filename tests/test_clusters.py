# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which beams count, and what makes them one cluster: every setting of step 4 does what it says."""

from __future__ import annotations

import numpy as np
import pytest

from edgefusion.config import PerceptionConfig
from edgefusion.perception.clusters import find_clusters
from edgefusion.types import Pose2D, Scan

STEP = np.radians(1)


def scan_of(*ranges_m: float, **limits: float) -> Scan:
    return Scan(0, np.array(ranges_m, np.float32), -STEP * (len(ranges_m) // 2), STEP, **limits)


def sizes(scan: Scan, **config) -> list[int]:
    return [len(cluster.indices) for cluster in find_clusters(scan, PerceptionConfig(**config))]


def test_eps_decides_what_is_one_thing() -> None:
    scan = scan_of(2.0, 2.0, 2.0, 2.25, 2.25, 2.25)
    assert sizes(scan, eps_m=0.3) == [6]
    assert sizes(scan, eps_m=0.2) == [3, 3]


def test_fewer_beams_than_min_points_are_noise() -> None:
    scan = scan_of(2.0, 2.0, 2.0, 9.0, 5.0, 5.0)
    assert sizes(scan, min_points=3) == [3]
    assert sizes(scan, min_points=2) == [3, 2]


def test_the_papers_features_join_what_lies_mirrored_about_the_robots_side() -> None:
    angles = np.radians(90) + STEP * np.array([-20, -19, -18, 18, 19, 20])
    ranges_m = np.full(41, np.inf, np.float32)
    ranges_m[[0, 1, 2, 38, 39, 40]] = 2.0
    scan = Scan(0, ranges_m, float(angles[0]), float(STEP))
    assert sizes(scan, features="xy") == [3, 3]
    assert sizes(scan, features="yr") == [6]


@pytest.mark.parametrize(
    ("limits", "beams"),
    [
        ({}, [0, 1, 2, 3]),
        ({"range_min_m": 2.0}, [0, 1, 2, 3]),
        ({"range_min_m": 2.015625}, [1, 2, 3]),
        ({"range_max_m": 2.046875}, [0, 1, 2, 3]),
        ({"range_max_m": 2.03125}, [0, 1, 2]),
    ],
)
def test_the_sensors_limits_are_inclusive_and_beams_outside_belong_to_nothing(limits, beams: list[int]) -> None:
    (cluster,) = find_clusters(scan_of(2.0, 2.015625, 2.03125, 2.046875, **limits), PerceptionConfig())
    assert cluster.indices.tolist() == beams


def test_no_return_unknown_too_near_and_zero_are_no_points() -> None:
    assert sizes(scan_of(np.inf, np.nan, -np.inf, 0.0, 0.0, 0.0, -1.0)) == []


def test_a_cluster_knows_its_nearest_beam_and_its_width() -> None:
    (cluster,) = find_clusters(scan_of(2.0, 1.9, 2.0), PerceptionConfig())
    assert cluster.range_m == pytest.approx(1.9)
    assert cluster.bearing == 0
    assert cluster.width_m == pytest.approx(np.hypot(4 * np.sin(STEP), 2 * np.cos(STEP) - 1.9), abs=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_scan_or_a_pose_that_is_not_finite_cannot_be_made(bad: float) -> None:
    with pytest.raises(ValueError, match="angles: expected finite values"):
        Scan(0, np.ones(3, np.float32), bad, 0.1)
    with pytest.raises(ValueError, match="angles: expected finite values"):
        Scan(0, np.ones(3, np.float32), 0.1, bad)
    for pose in ((bad, 0, 0), (0, bad, 0), (0, 0, bad)):
        with pytest.raises(ValueError, match="pose: expected finite values"):
            Pose2D(*pose)
