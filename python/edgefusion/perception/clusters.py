# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Neighbouring beams that hit one thing: DBSCAN over a scan, steps 2 and 4 of the paper."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from edgefusion._core import dbscan
from edgefusion.config import PerceptionConfig
from edgefusion.types import Cluster, Scan

Floats = npt.NDArray[np.float64]


def polar_to_plane(ranges_m: Floats, angles: Floats) -> Floats:
    """Points [n, 2] in the laser's plane [m]."""
    points: Floats = ranges_m[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points


def find_clusters(scan: Scan, config: PerceptionConfig) -> list[Cluster]:
    """Every cluster of a scan, nearest first; beams without a measured range belong to none."""
    ranges_m, angles = scan.ranges_m.astype(float), scan.angles
    with np.errstate(invalid="ignore"):  # NaN: unknown, REP 117
        hit = np.isfinite(ranges_m) & (ranges_m > scan.range_min_m) & (ranges_m <= scan.range_max_m)
    beams = np.flatnonzero(hit)
    points = polar_to_plane(ranges_m[beams], angles[beams])
    features = points if config.features == "xy" else np.stack([points[:, 1], ranges_m[beams]], axis=1)
    labels = dbscan(features, config.eps_m, config.min_points)

    clusters = [
        _cluster(beams[members], points[members], ranges_m, angles)
        for members in (np.flatnonzero(labels == label) for label in range(labels.max(initial=-1) + 1))
    ]
    return sorted(clusters, key=lambda cluster: cluster.range_m)


def _cluster(indices: npt.NDArray[np.int64], points: Floats, ranges_m: Floats, angles: Floats) -> Cluster:
    nearest = indices[ranges_m[indices].argmin()]
    return Cluster(
        indices=indices,
        range_m=float(ranges_m[nearest]),
        bearing=float(angles[nearest]),
        width_m=float(np.hypot(*np.ptp(points, axis=0))),
    )
