# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What outline a base's hull can have."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

from edgefusion.errors import RefusedError

LEAST_M = 0.05
"""From the middle of the axle to every side: a cell of the usual map. Nothing that drives is smaller."""

_ROUNDING_M = 1e-9

Point = Tuple[float, float]


def check_outline(name: str, corners_m: Sequence[Point]) -> None:
    """Raises RefusedError, with the name, for corners [k, 2] that are no convex outline, either way around, or one that
    has the origin, the middle of the axle, not LEAST_M inside."""
    sides = list(zip(corners_m, [*corners_m[1:], *corners_m[:1]]))
    sense = math.copysign(1, sum(_cross(a, b) for a, b in sides))
    for a, b in sides:
        length_m = math.dist(a, b)
        if length_m < _ROUNDING_M:
            raise RefusedError(f"{name}: expected corners apart from each other, got {a} twice in a row")
        normal = sense * (b[1] - a[1]) / length_m, -sense * (b[0] - a[0]) / length_m
        offset_m = _dot(normal, a)
        for corner in corners_m:
            if _dot(normal, corner) > offset_m + _ROUNDING_M:
                raise RefusedError(f"{name}: expected a convex outline, got {corner} beyond the side from {a} to {b}")
        if offset_m < LEAST_M:
            raise RefusedError(
                f"{name}: expected the middle of the axle, (0, 0), at least {LEAST_M:g} m inside of every side, "
                f"got {offset_m:g} m for the one from {a} to {b}"
            )


def _cross(a: Point, b: Point) -> float:
    return a[0] * b[1] - a[1] * b[0]


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1]
