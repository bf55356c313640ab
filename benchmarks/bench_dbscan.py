# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""DBSCAN of laser scans and of large clouds, against PyPI's `dbscan` and scikit-learn on one thread each."""

from __future__ import annotations

import os

os.environ["PARLAY_NUM_THREADS"] = "1"  # PyPI's dbscan reads it when it is imported

import math
from pathlib import Path
from typing import Callable

import dbscan as pypi
import numpy as np
import numpy.typing as npt
from sklearn.cluster import DBSCAN
from threadpoolctl import threadpool_limits
from timing import Row, interleaved

from edgefusion._core import dbscan
from edgefusion.recording.carmen import read_carmen

Points = npt.NDArray[np.float64]

CARMEN = Path(__file__).resolve().parents[2] / "shared" / "data" / "carmen"
PYPI, SCIKIT_LEARN = "PyPI dbscan", "scikit-learn"


def points_of(ranges_m: Points, angles: Points) -> Points:
    hit = np.isfinite(ranges_m)
    ranges_m, angles = ranges_m[hit].astype(float), angles[hit]
    return np.stack([ranges_m * np.cos(angles), ranges_m * np.sin(angles)], axis=1)


def real_scans(count: int) -> list[Points]:
    """Scans spread evenly over the real logs; none where they are absent."""
    scans = [scan for log in sorted(CARMEN.glob("*.log.gz")) for scan in read_carmen(log)]
    return [points_of(scan.ranges_m.astype(float), scan.angles) for scan in scans[:: len(scans) // count or 1]]


def room_scans(count: int) -> list[Points]:
    """Scans of a room 6 m deep and 8 m wide, with the noise of a SICK LMS."""
    random = np.random.default_rng(0)
    angles = np.linspace(-np.pi / 2, np.pi / 2, 361)
    with np.errstate(divide="ignore"):
        walls = np.minimum(6 / np.abs(np.cos(angles)), 4 / np.abs(np.sin(angles)))
    return [points_of(walls + random.normal(0, 0.01, 361), angles) for _ in range(count)]


def uniform(n: int, neighbours: float) -> Points:
    """n points of constant density: so many `neighbours` lie within a distance of 1."""
    return np.random.default_rng(n).uniform(0, math.sqrt(n * math.pi / neighbours), (n, 2))


def candidates(clouds: list[Points], eps: float, min_points: int) -> dict[str, Callable[[], object]]:
    """Several clouds in one call: on a single one, repeated, the processor would learn every branch."""
    return {
        "product": lambda: [dbscan(points, eps, min_points) for points in clouds],
        PYPI: lambda: [pypi.DBSCAN(points, eps, min_points) for points in clouds],
        SCIKIT_LEARN: lambda: [DBSCAN(eps=eps, min_samples=min_points).fit(points) for points in clouds],
    }


def compare(name: str, clouds: list[Points], eps: float, aims: dict[str, float], rounds: int) -> list[Row]:
    calls = candidates(clouds, eps, min_points=5)
    median = interleaved({peer: calls[peer] for peer in ("product", *aims)}, rounds)
    each = {peer: seconds / len(clouds) for peer, seconds in median.items()}
    product_s = each["product"]
    return [Row(name, product_s, peer, each[peer], each[peer] / product_s, aim) for peer, aim in aims.items()]


def rows(rounds: int = 21) -> list[Row]:
    """The rows of the common table."""
    real = real_scans(40)
    scans, kind = (real, "real") if real else (room_scans(40), "synthetic")
    table: list[Row] = []
    with threadpool_limits(1):
        for eps in (0.1, 0.2, 0.3, 0.5):
            name = f"dbscan, {kind} scan of 361 beams, eps {eps} m"
            table += compare(name, scans, eps, {PYPI: 8, SCIKIT_LEARN: 90}, rounds)
        for neighbours in (3, 12):
            for n in (10_000, 100_000, 1_000_000):
                name = f"dbscan, {n} points, {neighbours} within eps"
                table += compare(name, [uniform(n, neighbours)], 1.0, {PYPI: 10}, max(5, rounds * 10_000 // n))
    return table


if __name__ == "__main__":
    for row in rows():
        ours, peers = 1e6 * row.product_s, 1e6 * row.peer_s
        print(f"{row.name}: {ours:.1f} us, {row.peer} {peers:.1f} us, {row.ratio:.1f} times (aim {row.aim:g})")
