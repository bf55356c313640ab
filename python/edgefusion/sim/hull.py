# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A convex hull in the plan, and how near it comes to segments: exactly, and cheaply where they are far."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.sim.floor_plan import distances_m
from edgefusion.types import Pose2D

Floats = npt.NDArray[np.float64]
Point = Tuple[float, float]


class Bounded(NamedTuple):
    """Segments [m, 4] with the circles about them: middles float64[2, m], halves of their lengths float64[m]."""

    segments: Floats
    middles: Floats
    halves_m: Floats


def bounded(segments: Floats) -> Bounded:
    """The segments [m, 4] (x0, y0, x1, y1) with their circles."""
    start, end = segments[:, :2], segments[:, 2:]
    return Bounded(segments, (start + end).T / 2, np.hypot(*(end - start).T) / 2)


class Hull:
    """corners_m: float64[k, 2], counter-clockwise, in base_link. They may be given clockwise, too.

    Raises RefusedError for fewer than three corners, and for an outline that is not convex.
    """

    def __init__(self, corners_m: Sequence[Point]) -> None:
        self.corners_m = _counter_clockwise(np.asarray(corners_m, float))
        along = np.roll(self.corners_m, -1, axis=0) - self.corners_m
        self._normals = np.stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)  # outwards, [2, k]
        self._offsets_m = (self.corners_m.T * self._normals).sum(axis=0)
        self._edges = np.hstack([self.corners_m, np.roll(self.corners_m, -1, axis=0)])
        self._middle = (self.corners_m.min(axis=0) + self.corners_m.max(axis=0)) / 2
        self._radius_m = float(np.hypot(*(self.corners_m - self._middle).T).max())

    def at(self, pose: Pose2D) -> Floats:
        """The corners [k, 2] where the base stands there."""
        return np.asarray(self.corners_m @ _rotation(pose.theta).T + (pose.x_m, pose.y_m))

    def clearance_m(self, pose: Pose2D, plan: Bounded, below_m: float = math.inf) -> float:
        """From the hull at a pose to the nearest segment, 0 where one touches it or lies inside; inf where that is not
        less than below_m."""
        middle = _rotation(pose.theta) @ self._middle + (pose.x_m, pose.y_m)
        dx, dy = plan.middles[0] - middle[0], plan.middles[1] - middle[1]
        near = plan.segments[dx * dx + dy * dy < (plan.halves_m + self._radius_m + below_m) ** 2]
        if not len(near):
            return math.inf
        segments = _seen_from(pose, near)
        beyond = segments.reshape(-1, 2, 2) @ self._normals - self._offsets_m  # each end, beyond each edge [m]
        # A segment all of which is so far beyond one edge is no nearer than that.
        kept = beyond.min(axis=1).max(axis=1) < below_m
        nearest_m = self._nearest_m(segments[kept], beyond[kept]) if kept.any() else math.inf
        return nearest_m if nearest_m < below_m else math.inf

    def _nearest_m(self, segments: Floats, beyond: Floats) -> float:
        """From the hull to the nearest of some segments in base_link."""
        if _meets(beyond[:, 0], beyond[:, 1]).any():
            return 0.0
        # What does not cross is nearest at a corner of the hull or at an end of a segment.
        ends = segments.reshape(-1, 2)
        return float(min(distances_m(self.corners_m, segments).min(), distances_m(ends, self._edges).min()))


def _meets(start: Floats, end: Floats) -> npt.NDArray[np.bool_]:
    """Which segments have a point inside all edges: each edge leaves a part of a segment. start, end: how far its ends
    are beyond each edge, [n, k]."""
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = start / (start - end)
    enters = np.where((start > 0) & (end <= 0), crossing, 0.0).max(axis=1)
    leaves = np.where((start <= 0) & (end > 0), crossing, 1.0).min(axis=1)
    outside = ((start > 0) & (end > 0)).any(axis=1)
    return np.asarray(~outside & (enters <= leaves))


def _counter_clockwise(corners_m: Floats) -> Floats:
    if corners_m.ndim != 2 or corners_m.shape[1] != 2 or len(corners_m) < 3:
        raise RefusedError(f"hull: expected at least 3 corners [k, 2], got {list(corners_m.shape)}")
    along = np.roll(corners_m, -1, axis=0) - corners_m
    onward = np.roll(along, -1, axis=0)
    turns = along[:, 0] * onward[:, 1] - along[:, 1] * onward[:, 0]
    if not ((turns > 0).all() or (turns < 0).all()):
        raise RefusedError(f"hull: expected a convex outline, got corners {corners_m.tolist()}")
    return corners_m if turns[0] > 0 else np.asarray(corners_m[::-1])


def _rotation(theta: float) -> Floats:
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s], [s, c]])


def _seen_from(pose: Pose2D, segments: Floats) -> Floats:
    """World segments [n, 4] in the pose's frame."""
    ends = segments.reshape(-1, 2) - (pose.x_m, pose.y_m)
    return np.asarray((ends @ _rotation(pose.theta)).reshape(-1, 4))
