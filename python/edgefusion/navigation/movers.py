# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who walks about: things where nothing was a moment ago, followed from scan to scan, and where they will be."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Tuple

import numpy as np
import numpy.typing as npt

from edgefusion._core import ObstacleMap
from edgefusion.types import Pose2D, Scan

Floats = npt.NDArray[np.float64]

GAP_M, WIDEST_M = 0.25, 1.2
"""Neighbouring beams farther apart belong to two things; a wider thing is no person."""

YOUNG_S, YOUNG_SHARE = 1.5, 0.5
"""Most of what is seen of a mover is where nothing was so long ago."""

BODY_M, ROOM_M, SPREAD_MPS = 0.3, 0.45, 0.15
"""Radius of what a mover is taken to be, behind what is seen of it; of what is kept free for it; and how that grows
with the time for which it is foretold."""

SLOWEST_MPS, FASTEST_MPS = 0.25, 2.5
_COASTS_S, _RIM_OF_VIEW = 3.0, math.radians(30)
STEADY_M = 0.15
"""A mover is never farther off the straight line that it walks."""

_GATE_M, _LOST_S, _SPAN_S, _LEAST_S, _LEAST_SEEN = 0.5, 0.7, 0.7, 0.25, 3
_RIM = np.stack([np.cos(np.arange(12) * math.pi / 6), np.sin(np.arange(12) * math.pi / 6)], axis=1)
_NS_PER_S = 1e9


@dataclass
class Track:
    """Where a thing was seen: (stamp_ns, centre). velocity: (vx, vy) [m/s], once it was seen for long enough."""

    seen: list[tuple[int, Floats]] = field(default_factory=list)
    velocity: Tuple[float, float] | None = None

    def expected(self, stamp_ns: int) -> Floats:
        last_ns, place = self.seen[-1]
        return place + np.asarray(self.velocity or (0.0, 0.0)) * (stamp_ns - last_ns) / _NS_PER_S

    def add(self, stamp_ns: int, place: Floats, whole: bool) -> None:
        """whole: nothing of it reaches out of the view; else it seems to be slower than it is."""
        self.seen = [entry for entry in self.seen if stamp_ns - entry[0] <= _SPAN_S * _NS_PER_S] + [(stamp_ns, place)]
        times = np.array([ns - stamp_ns for ns, _ in self.seen]) / _NS_PER_S
        if times[-1] - times[0] < _LEAST_S or len(times) < _LEAST_SEEN:
            return
        places = np.array([place for _, place in self.seen])
        off, from_middle = times - times.mean(), places - places.mean(axis=0)
        velocity = off @ from_middle / (off @ off)
        if np.abs(from_middle - off[:, None] * velocity).max() > STEADY_M:
            self.velocity = None  # what jumps about is no walker
        elif whole or self.velocity is None or np.hypot(*velocity) > math.hypot(*self.velocity):
            self.velocity = float(velocity[0]), float(velocity[1])

    def rim(self, stamp_ns: int) -> Floats:
        """The room that it is left at a time, [k, 4] as (x, y, vx, vy)."""
        ahead_s = (stamp_ns - self.seen[-1][0]) / _NS_PER_S
        places = self.expected(stamp_ns) + (ROOM_M + SPREAD_MPS * ahead_s) * _RIM
        return np.hstack([places, np.asarray(self.velocity or (0.0, 0.0)) + SPREAD_MPS * _RIM])

    @property
    def moves(self) -> bool:
        return self.velocity is not None and SLOWEST_MPS <= math.hypot(*self.velocity) <= FASTEST_MPS


class Movers:
    """Tracks of all that appeared where nothing was."""

    def __init__(self) -> None:
        self._tracks: list[Track] = []

    def see(self, scan: Scan, ends: Floats, laser: Pose2D, seen: ObstacleMap) -> None:
        """ends [n, 2]: what the beams met, in the map, in the order of the beams, the scan already on it; laser: its
        pose in the map."""
        eye = laser.x_m, laser.y_m
        young = seen.ages(ends, scan.stamp_ns) < YOUNG_S
        for part in _things(ends):
            if young[part].mean() < YOUNG_SHARE:
                continue
            centre, whole = _centre(ends[part], eye), 0 < part.start and part.stop < len(ends)
            self._nearest(scan.stamp_ns, centre).add(scan.stamp_ns, centre, whole)
        self._tracks = [track for track in self._tracks if _lasts(track, scan, laser)]

    def at(self, stamp_ns: int) -> Floats:
        """The rims of all movers at a time, [k, 4] as (x, y, vx, vy)."""
        rims = [track.rim(stamp_ns) for track in self._tracks if track.moves]
        return np.concatenate(rims) if rims else np.zeros((0, 4))

    def _nearest(self, stamp_ns: int, centre: Floats) -> Track:
        """The track that a thing belongs to: the nearest that was not continued by this scan, or a new one."""
        open_ = [track for track in self._tracks if track.seen[-1][0] != stamp_ns]
        apart = [float(np.hypot(*(track.expected(stamp_ns) - centre))) for track in open_]
        if apart and min(apart) < _GATE_M:
            return open_[apart.index(min(apart))]
        self._tracks.append(Track())
        return self._tracks[-1]


def _lasts(track: Track, scan: Scan, laser: Pose2D) -> bool:
    """Whether a mover that is not seen now is still believed in: longer where the laser hardly looks."""
    unseen_s = (scan.stamp_ns - track.seen[-1][0]) / _NS_PER_S
    if unseen_s <= _LOST_S:
        return True
    dx, dy = track.expected(scan.stamp_ns) - (laser.x_m, laser.y_m)
    half_view = scan.angle_increment * (len(scan.ranges_m) - 1) / 2
    off = abs(math.remainder(math.atan2(dy, dx) - laser.theta - scan.angle_min - half_view, 2 * math.pi))
    return track.moves and off > abs(half_view) - _RIM_OF_VIEW and unseen_s <= _COASTS_S


def _things(ends: Floats) -> list[slice]:
    """Runs of neighbouring points that may be a person."""
    if not len(ends):
        return []
    steps = np.hypot(*np.diff(ends, axis=0).T)
    edges = np.concatenate([[0], np.nonzero(steps > GAP_M)[0] + 1, [len(ends)]])
    runs = [slice(int(a), int(b)) for a, b in zip(edges, edges[1:])]
    return [run for run in runs if run.stop - run.start >= 2 and np.ptp(ends[run], axis=0).max() <= WIDEST_M]


def _centre(points: Floats, eye: Tuple[float, float]) -> Floats:
    """A body's radius, less what is seen to bulge, behind what is seen."""
    middle = points.mean(axis=0)
    away = middle - eye
    return np.asarray(middle + 0.6 * BODY_M * away / max(float(np.hypot(*away)), 1e-6))
