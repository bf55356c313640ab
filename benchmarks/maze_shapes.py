# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What mazes are built of, as segments float64[m, 4] (x0, y0, x1, y1) [m]: closed outlines of walls and things."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Rng = np.random.Generator
Point = Tuple[float, float]

THICK_M = 0.1
"""Of a wall."""

_SIDES = 12
_TRIES = 400


def outline(corners: Floats) -> Floats:
    """The closed outline of corners [k, 2]."""
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


def room(width_m: float, height_m: float) -> Floats:
    """Four walls from the origin to (width, height), seen from inside."""
    return box((width_m / 2, height_m / 2), width_m, height_m)


def box(middle: Point, width_m: float, height_m: float, angle: float = 0.0) -> Floats:
    """A rectangle about a point, turned."""
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (width_m / 2, height_m / 2)
    return outline(turned(corners, angle) + middle)


def disc(middle: Point, radius_m: float) -> Floats:
    """A polygon about a circle, which it touches from outside."""
    angles = 2 * math.pi / _SIDES * np.arange(_SIDES)
    corners = np.stack([np.cos(angles), np.sin(angles)], axis=1) * radius_m / math.cos(math.pi / _SIDES)
    return outline(corners + middle)


def wall(start: Point, end: Point) -> Floats:
    """A wall THICK_M wide between two points, which are in the middle of its ends."""
    way = np.subtract(end, start)
    middle = np.add(start, end) / 2
    return box((middle[0], middle[1]), float(np.hypot(*way)), THICK_M, math.atan2(way[1], way[0]))


def walls(points: Sequence[Point]) -> Floats:
    """A wall from point to point, its corners filled."""
    posts = [box(point, THICK_M, THICK_M) for point in points[1:-1]]
    return np.vstack([wall(a, b) for a, b in zip(points, points[1:])] + posts)


def turned(points: Floats, angle: float) -> Floats:
    """Points [k, 2] turned about the origin."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def placed(segments: Floats, middle: Point, angle: float) -> Floats:
    """Segments turned about the origin, then moved so that it comes to `middle`."""
    return np.asarray(turned(segments.reshape(-1, 2), angle) + middle).reshape(-1, 4)


def clutter(rng: Rng, width_m: float, height_m: float, count: int, gap_m: float, free: Sequence[Point]) -> Floats:
    """Up to `count` boxes and pillars in a room, the first in the middle of the way between the first two of the
    points that stay free. Everywhere between them, the walls and the free points it is at least gap_m wide."""
    found: list[tuple[Point, float]] = []
    things = [np.zeros((0, 4))]
    for attempt in range(_TRIES):
        if len(found) == count:
            break
        radius_m = float(rng.uniform(0.15, 0.5))
        low, high = radius_m + gap_m, (width_m - radius_m - gap_m, height_m - radius_m - gap_m)
        at = (float(rng.uniform(low, high[0])), float(rng.uniform(low, high[1])))
        if attempt == 0:
            at = ((free[0][0] + free[1][0]) / 2, (free[0][1] + free[1][1]) / 2)
        others = [*found, *((point, 0.0) for point in free)]
        if all(math.dist(at, other) >= radius_m + size_m + gap_m for other, size_m in others):
            found.append((at, radius_m))
            things.append(_thing(rng, at, radius_m))
    return np.vstack(things)


def _thing(rng: Rng, at: Point, radius_m: float) -> Floats:
    """A box or a pillar within a circle."""
    if rng.random() < 0.5:
        return disc(at, radius_m * math.cos(math.pi / _SIDES))
    angle = float(rng.uniform(0.5, 1.0))  # of the diagonal
    return box(at, 2 * radius_m * math.cos(angle), 2 * radius_m * math.sin(angle), float(rng.uniform(0, math.pi)))
