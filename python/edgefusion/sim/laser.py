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
from edgefusion.errors import RefusedError
from edgefusion.sim.edges import ExactScan, edges
from edgefusion.types import Pose2D, Scan, read_only

Floats = npt.NDArray[np.float64]
Hits = npt.NDArray[np.int32]
Rng = np.random.Generator
PoseAt = Callable[[int], Pose2D]
"""The laser's pose in the world at a time [ns]."""


@dataclass(frozen=True)
class LaserSpec:
    """An LMS200 at half a degree, by default: 361 beams from right to left, two mirror turns a scan.

    range_max_m: from here on it sees nothing (8183 mm is what an LMS200 sends for that as delivered). sigma_m: noise
    of a range. dropped: share of beams without an answer. mixed: share of edges at which a beam reads something between
    the two surfaces. edge_m: what makes an edge of two neighbouring ranges. interlaced: even beams are measured in one
    mirror turn, odd ones in the next; turn_ns: what a turn takes.
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

    def __post_init__(self) -> None:
        if self.beams < 1:
            raise RefusedError(f"beams: expected at least 1, got {self.beams}")
        for name in ("dropped", "mixed"):
            if not 0 <= getattr(self, name) <= 1:
                raise RefusedError(f"{name}: expected a share from 0 to 1, got {getattr(self, name)}")
        for name in ("sigma_m", "edge_m", "turn_ns"):
            if not 0 <= getattr(self, name) < math.inf:
                raise RefusedError(f"{name}: expected a finite number of at least 0, got {getattr(self, name)}")


class SimLaser:
    """Scans a floor plan. What it draws comes from the generator that it is handed, nothing else."""

    def __init__(self, spec: LaserSpec | None = None) -> None:
        self._spec = spec or LaserSpec()
        self.beam_dt_ns = read_only(_beam_times(self._spec))

    def scan(self, stamp_ns: int, segments: Floats, pose_at: PoseAt, rng: Rng) -> tuple[Scan, Hits]:
        """A scan whose middle beam is measured at stamp_ns, and the row of `segments` [m, 4] that each beam met.

        The rows are those of the nearest surface, -1 for none, also where a beam is dropped or reads between two.
        Raises whatever pose_at raises for times from a scan's first beam to its last, and what `raycast` refuses.
        """
        spec = self._spec
        exact = self._exact(stamp_ns, segments, pose_at)
        at = edges(exact, segments, spec.edge_m) if spec.mixed else np.empty(0, np.intp)  # finding them takes a while
        ranges_m = self._mixed(exact.ranges_m, at, rng)
        scan = Scan(
            stamp_ns,
            self._measured(ranges_m, rng),
            spec.angle_min,
            spec.angle_increment,
            range_max_m=spec.range_max_m,
            beam_dt_ns=self.beam_dt_ns,
        )
        return scan, exact.hits

    def _exact(self, stamp_ns: int, segments: Floats, pose_at: PoseAt) -> ExactScan:
        """What the beams meet, each mirror turn from where the laser is meanwhile."""
        n, turns = self._spec.beams, 2 if self._spec.interlaced and self._spec.beams > 1 else 1
        scan = ExactScan(np.empty((n, 2)), np.empty(n), np.empty(n), np.empty(n, np.int32))
        for turn in range(turns):
            mine = slice(turn, None, turns)
            origin, first, step = self._rays(turn, turns, stamp_ns, pose_at)
            count = len(scan.ranges_m[mine])
            scan.origins[mine], scan.angles[mine] = origin, first + step * np.arange(count)
            scan.ranges_m[mine], scan.hits[mine] = raycast(
                segments, [*origin, first], 0.0, step, count, self._spec.range_max_m
            )
        return scan

    def _rays(self, turn: int, turns: int, stamp_ns: int, pose_at: PoseAt) -> tuple[tuple[float, float], float, float]:
        """Origin of a mirror turn's beams, direction of the first, step to the next, in the world.

        A turning robot stretches or narrows the step. Its way while the mirror sweeps, a few millimetres, is left out.
        """
        spec, times_ns = self._spec, self.beam_dt_ns[turn::turns]
        start, middle, end = (pose_at(stamp_ns + int(times_ns[i])) for i in (0, len(times_ns) // 2, -1))
        turned = math.remainder(end.theta - start.theta, 2 * math.pi) / max(1, len(times_ns) - 1)
        first = start.theta + spec.angle_min + turn * spec.angle_increment
        return (middle.x_m, middle.y_m), first, turns * spec.angle_increment + turned

    def _mixed(self, exact: Floats, at: npt.NDArray[np.intp], rng: Rng) -> Floats:
        """At some edges one of the two beams reads between the surfaces: its spot lies on both."""
        chance, side, share = rng.random((3, len(at)))
        between = exact[at] + share * (exact[at + 1] - exact[at])
        mixed = chance < self._spec.mixed
        ranges_m = exact.copy()
        ranges_m[(at + (side < 0.5))[mixed]] = between[mixed]
        return ranges_m

    def _measured(self, ranges_m: Floats, rng: Rng) -> npt.NDArray[np.float32]:
        """With noise, in the whole millimetres of the wire, and without the beams that get no answer."""
        noisy = ranges_m + self._spec.sigma_m * rng.standard_normal(len(ranges_m))
        sent = np.round(np.maximum(noisy, 0.0), 3)
        sent[sent >= self._spec.range_max_m] = np.inf
        sent[rng.random(len(sent)) < self._spec.dropped] = np.nan
        return sent.astype(np.float32)


def _beam_times(spec: LaserSpec) -> npt.NDArray[np.int64]:
    """When each beam is measured, from the middle one's time [ns]: half a mirror turn sweeps 180 degrees."""
    swept = np.arange(spec.beams) * abs(spec.angle_increment) / (2 * math.pi)
    late = np.arange(spec.beams) % 2 if spec.interlaced else np.zeros(spec.beams)
    times = (swept + late) * spec.turn_ns
    from_middle: npt.NDArray[np.int64] = np.rint(times - times[spec.beams // 2]).astype(np.int64)
    return from_middle
