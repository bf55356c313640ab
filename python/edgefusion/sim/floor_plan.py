# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a laser at some height sees of a world: its surfaces cut by a level plane, as line segments with owners."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from edgefusion.sim.mesh import Part
from edgefusion.types import read_only

Floats = npt.NDArray[np.float64]

BUILDING = -1
"""Owner of what belongs to no object: walls."""

NOTHING_MET = -2
"""Owner of a beam that met no surface."""

_SHORTEST_M = 1e-6


def cut(parts: Iterable[Part], height_m: float) -> Floats:
    """Where a level plane cuts the surfaces: segments [m, 4], (x0, y0, x1, y1)."""
    triangles = [part.vertices.astype(float)[part.triangles] for part in parts]
    if not triangles:
        return np.zeros((0, 4))
    corners = np.concatenate(triangles)
    # A corner exactly in the plane counts as above it, so that shared edges are cut once, or not at all.
    above = corners[:, :, 2] >= height_m
    crossing = corners[above.any(axis=1) & ~above.all(axis=1)]
    above = crossing[:, :, 2] >= height_m
    # The corner that is alone on its side first: the plane cuts the two edges that leave it.
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    a, b, c = (crossing[np.arange(len(crossing)), order[:, i]] for i in range(3))
    segments = np.hstack([_at_height(a, b, height_m), _at_height(a, c, height_m)])
    long_enough = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]) > _SHORTEST_M
    return np.ascontiguousarray(segments[long_enough])


def _at_height(a: Floats, b: Floats, height_m: float) -> Floats:
    """Where edges [n, 3] from a to b pass the height: [n, 2]."""
    share = (height_m - a[:, 2]) / (b[:, 2] - a[:, 2])
    return np.asarray(a[:, :2] + share[:, None] * (b[:, :2] - a[:, :2]))


@dataclass(frozen=True)
class FloorPlan:
    """segments: float64[m, 4] in the world [m]; owners: int32[m], the object's index or BUILDING."""

    segments: Floats
    owners: npt.NDArray[np.int32]

    def of(self, owner: int) -> Floats:
        """The segments of one owner."""
        return np.asarray(self.segments[self.owners == owner])

    def owners_of(self, hits: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
        """Whose surface each beam met, int32[beams]: an object's index, BUILDING or NOTHING_MET. hits: the row of
        segments that it met, -1 for none."""
        owners = np.full(len(hits), NOTHING_MET, np.int32)
        owners[hits >= 0] = self.owners[hits[hits >= 0]]
        return owners

    def nearest_m(self, owner: int, point: tuple[float, float]) -> float:
        """From a point (x, y) to the nearest of the owner's surface; inf where the plane misses it."""
        return float(distances_m([point], self.of(owner)).min(initial=np.inf))

    def clearance_m(self, owner: int) -> float:
        """From an object to whatever else is nearest; inf where there is nothing."""
        own, rest = self.of(owner), self.segments[self.owners != owner]
        # Segments that do not cross are nearest at an end of one of them.
        ends = [distances_m(a[:, k : k + 2], b) for a, b in ((own, rest), (rest, own)) for k in (0, 2)]
        return float(min(each.min(initial=np.inf) for each in ends))


def floor_plan(building: Sequence[Part], bodies: Sequence[Sequence[Part]], height_m: float) -> FloorPlan:
    """The plan of walls and objects, each by its index, at a height."""
    cuts = [cut(building, height_m), *(cut(body, height_m) for body in bodies)]
    owners = np.repeat(np.arange(BUILDING, len(bodies)), [len(each) for each in cuts])
    return FloorPlan(read_only(np.concatenate(cuts)), read_only(owners.astype(np.int32)))


def distances_m(points: npt.ArrayLike, segments: Floats) -> Floats:
    """From points [n, 2] to segments [m, 4]: [n, m]."""
    start, edge = segments[:, :2], segments[:, 2:] - segments[:, :2]
    away = np.asarray(points, float)[:, None] - start
    share = np.clip((away * edge).sum(axis=2) / np.maximum((edge * edge).sum(axis=1), 1e-12), 0, 1)
    apart = away - share[..., None] * edge
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]))
