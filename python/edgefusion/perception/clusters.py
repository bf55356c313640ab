# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Neighbouring beams that hit one thing: DBSCAN over a scan, steps 2 and 4 of the paper; what touches is split."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from edgefusion._core import dbscan, split_clusters
from edgefusion.config import PerceptionConfig
from edgefusion.types import Cluster, Scan

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Labels = npt.NDArray[np.int32]


def polar_to_plane(ranges_m: Floats, angles: Floats) -> Floats:
    """Points [n, 2] in the laser's plane [m]."""
    points: Floats = ranges_m[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points


def find_clusters(scan: Scan, config: PerceptionConfig) -> list[Cluster]:
    """Every cluster of a scan, nearest first; beams without a measured range belong to none."""
    ranges_m, angles = scan.ranges_m.astype(float), scan.angles
    with np.errstate(invalid="ignore"):  # NaN: unknown, REP 117
        hit = (ranges_m > 0) & (ranges_m >= scan.range_min_m) & (ranges_m <= scan.range_max_m) & np.isfinite(ranges_m)
    beams = np.flatnonzero(hit)
    points = polar_to_plane(ranges_m[beams], angles[beams])
    features = points if config.features == "xy" else np.stack([points[:, 1], ranges_m[beams]], axis=1)
    labels = dbscan(features, config.eps_m, config.min_points)
    if config.split:
        labels = split_clusters(points, labels, config.range_sigma_m, config.eps_m, config.min_points)
    return _nearest_first(labels, beams, points, ranges_m, angles)


def _nearest_first(labels: Labels, beams: Indices, points: Floats, ranges_m: Floats, angles: Floats) -> list[Cluster]:
    """The clusters of labelled points [n, 2], all measured at once: a scan has dozens."""
    order = np.argsort(labels, kind="stable")  # cluster after cluster, beams rising; noise, -1, first
    begins = np.searchsorted(labels[order], np.arange(labels.max(initial=-1) + 1))
    if not len(begins):
        return []
    members = beams[order]
    nearest_m = np.minimum.reduceat(ranges_m[members], begins)
    extent = np.maximum.reduceat(points[order], begins) - np.minimum.reduceat(points[order], begins)
    widths_m = np.hypot(extent[:, 0], extent[:, 1])
    ends = np.append(begins[1:], len(members))
    clusters = []
    for i in np.argsort(nearest_m, kind="stable").tolist():
        indices = members[begins[i] : ends[i]]
        bearing = angles[indices[ranges_m[indices].argmin()]]
        clusters.append(Cluster(indices, float(nearest_m[i]), float(bearing), float(widths_m[i])))
    return clusters
