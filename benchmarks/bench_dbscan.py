# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""DBSCAN of laser scans and of large clouds, against PyPI's `dbscan` and scikit-learn on one thread each."""

from __future__ import annotations

import os

os.environ["PARLAY_NUM_THREADS"] = "1"  # PyPI's dbscan reads it when it is imported

import math
from pathlib import Path
from statistics import median
from typing import Callable, Dict, Iterable

import dbscan as pypi
import numpy as np
import numpy.typing as npt
from benchmarks.timing import Row, interleaved
from sklearn.cluster import DBSCAN
from threadpoolctl import threadpool_limits

from edgefusion._core import dbscan
from edgefusion.recording.carmen import read_carmen

Points = npt.NDArray[np.float64]
Medians = Dict[str, float]

CARMEN = Path(__file__).resolve().parents[2] / "shared" / "data" / "carmen"
PRODUCT, PYPI, SCIKIT_LEARN = "product", "PyPI dbscan", "scikit-learn"


def points_of(ranges_m: Points, angles: Points) -> Points:
    hit = np.isfinite(ranges_m)
    ranges_m, angles = ranges_m[hit], angles[hit]
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
    return {
        PRODUCT: lambda: [dbscan(points, eps, min_points) for points in clouds],
        PYPI: lambda: [pypi.DBSCAN(points, eps, min_points) for points in clouds],
        SCIKIT_LEARN: lambda: [DBSCAN(eps=eps, min_samples=min_points).fit(points) for points in clouds],
    }


def medians(clouds: list[Points], eps: float, min_points: int, peers: Iterable[str], rounds: int) -> Medians:
    """Seconds per cloud."""
    calls = candidates(clouds, eps, min_points)
    taken = interleaved({name: calls[name] for name in (PRODUCT, *peers)}, rounds)
    return {name: seconds / len(clouds) for name, seconds in taken.items()}


def table_rows(name: str, measured: list[Medians], aims: dict[str, float | None]) -> list[Row]:
    """One row for each peer: medians over all that was measured, of the seconds and of the ratio."""
    return [
        Row(
            name,
            product_s=median(seconds[PRODUCT] for seconds in measured),
            peer=peer,
            peer_s=median(seconds[peer] for seconds in measured),
            ratio=median(seconds[peer] / seconds[PRODUCT] for seconds in measured),
            aim=aim,
        )
        for peer, aim in aims.items()
    ]


def scan_rows(rounds: int) -> list[Row]:
    """Each scan by itself, again and again; then all in turn: no branch is learnt by heart."""
    real = real_scans(20)
    scans, kind = (real, "real") if real else (room_scans(20), "synthetic")
    aims: dict[str, float | None] = {PYPI: 8, SCIKIT_LEARN: 90}
    table: list[Row] = []
    for eps in (0.1, 0.2, 0.3, 0.5):
        name = f"dbscan, {kind} scan of 361 beams, eps {eps} m"
        alone = [medians([scan], eps, 3, aims, rounds) for scan in scans]
        in_turn = [medians(scans, eps, 3, aims, rounds)]
        table += table_rows(name, alone, aims)
        table += table_rows(f"{name}, in turn", in_turn, dict.fromkeys(aims))
    return table


def cloud_rows(rounds: int) -> list[Row]:
    table: list[Row] = []
    for neighbours in (3, 12):
        for n in (10_000, 100_000, 1_000_000):
            measured = medians([uniform(n, neighbours)], 1.0, 5, [PYPI], max(5, rounds * 10_000 // n))
            table += table_rows(f"dbscan, {n} points, {neighbours} within eps", [measured], {PYPI: 10})
    return table


def rows(rounds: int = 11) -> list[Row]:
    """The rows of the common table."""
    with threadpool_limits(1):
        return scan_rows(rounds) + cloud_rows(rounds)


if __name__ == "__main__":
    for row in rows():
        aim = "" if row.aim is None else f" (aim {row.aim:g})"
        ours, peers = 1e6 * row.product_s, 1e6 * row.peer_s
        print(f"{row.name}: {ours:.1f} us, {row.peer} {peers:.1f} us, {row.ratio:.1f} times{aim}")
