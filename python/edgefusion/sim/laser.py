# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated LMS2xx: exact ranges, then everything that spoils them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np
import numpy.typing as npt

from edgefusion._core import raycast
from edgefusion.types import Pose2D, Scan, read_only

Floats = npt.NDArray[np.float64]
Hits = npt.NDArray[np.int32]
Rng = np.random.Generator
PoseAt = Callable[[int], Pose2D]
"""The laser's pose in the world at a time [ns]."""


@dataclass(frozen=True)
class LaserSpec:
    """An LMS200 at half a degree, by default: 361 beams from right to left, two mirror turns a scan.

    sigma_m: noise of a range. dropped: share of beams without an answer. mixed: share of edges at which a beam reads
    something between the two surfaces. edge_m: what makes an edge of two neighbouring ranges. interlaced: even beams
    are measured in one mirror turn, odd ones in the next; turn_ns: what a turn takes.
    """

    beams: int = 361
    angle_min: float = -math.pi / 2
    angle_increment: float = math.radians(0.5)
    range_max_m: float = 8.183
    sigma_m: float = 0.01
    dropped: float = 0.01
    mixed: float = 0.5
    edge_m: float = 0.1
    interlaced: bool = True
    turn_ns: int = 13_333_333


class SimLaser:
    """Scans a floor plan. What it draws comes from the generator that it is handed, nothing else."""

    def __init__(self, spec: LaserSpec | None = None) -> None:
        self._spec = spec or LaserSpec()
        self.beam_dt_ns = read_only(_beam_times(self._spec))

    def scan(self, stamp_ns: int, segments: Floats, pose_at: PoseAt, rng: Rng) -> tuple[Scan, Hits]:
        """A scan whose middle beam is measured at stamp_ns, and the row of `segments` [m, 4] that each beam met.

        The rows are those of the nearest surface, -1 for none, also where a beam is dropped or reads between two.
        """
        exact, hits = self._cast(stamp_ns, segments, pose_at)
        ranges_m = self._mixed(exact, hits, rng)
        ranges_m = ranges_m + rng.normal(0, self._spec.sigma_m, len(ranges_m))
        ranges_m = np.asarray(np.round(np.maximum(ranges_m, 0.0), 3), float)  # the wire carries whole millimetres
        ranges_m[ranges_m > self._spec.range_max_m] = np.inf
        ranges_m[rng.random(len(ranges_m)) < self._spec.dropped] = np.nan
        spec = self._spec
        scan = Scan(
            stamp_ns,
            ranges_m.astype(np.float32),
            spec.angle_min,
            spec.angle_increment,
            range_max_m=spec.range_max_m,
            beam_dt_ns=self.beam_dt_ns,
        )
        return scan, hits

    def _cast(self, stamp_ns: int, segments: Floats, pose_at: PoseAt) -> tuple[Floats, Hits]:
        """Exact ranges, each mirror turn from where the laser was in its middle."""
        spec = self._spec
        ranges_m, hits = np.empty(spec.beams), np.empty(spec.beams, np.int32)
        turns = 2 if spec.interlaced else 1
        for turn in range(turns):
            pose = pose_at(stamp_ns + int(np.median(self.beam_dt_ns[turn::turns])))
            ranges_m[turn::turns], hits[turn::turns] = raycast(
                segments,
                [pose.x_m, pose.y_m, pose.theta],
                spec.angle_min + turn * spec.angle_increment,
                turns * spec.angle_increment,
                len(ranges_m[turn::turns]),
                spec.range_max_m,
            )
        return ranges_m, hits

    def _mixed(self, exact: Floats, hits: Hits, rng: Rng) -> Floats:
        """At some edges one of the two beams reads between the surfaces: its spot lies on both."""
        ranges_m = exact.copy()
        for i in np.flatnonzero(_edges(exact, hits, self._spec.edge_m)).tolist():
            chance, side, share = rng.random(3)
            if chance < self._spec.mixed:
                ranges_m[i + int(side < 0.5)] = exact[i] + share * (exact[i + 1] - exact[i])
        return ranges_m


def _edges(exact: Floats, hits: Hits, edge_m: float) -> npt.NDArray[np.bool_]:
    """Where a beam and the next meet different surfaces that are a step apart, both within range."""
    with np.errstate(invalid="ignore"):  # inf - inf
        step = np.abs(np.diff(exact)) > edge_m
    return np.asarray(step & (hits[:-1] != hits[1:]) & (hits[:-1] >= 0) & (hits[1:] >= 0))


def _beam_times(spec: LaserSpec) -> npt.NDArray[np.int64]:
    """When each beam is measured, from the middle one's time [ns]: half a mirror turn sweeps 180 degrees."""
    swept = np.arange(spec.beams) * abs(spec.angle_increment) / (2 * math.pi)
    late = np.arange(spec.beams) % 2 if spec.interlaced else np.zeros(spec.beams)
    times = (swept + late) * spec.turn_ns
    return np.asarray(np.rint(times - times[spec.beams // 2]), np.int64)
