# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the builders of objects share: sizes that vary, round parts that point forward, castors, rounded plates."""

from __future__ import annotations

from typing import Iterable, Sequence

import numpy as np

from edgefusion.sim.kinds.kind import Size
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain
from edgefusion.sim.paint import Rng

UP_TO_FRONT = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0))


def varied(rng: Rng, size_m: Size, spread: float = 0.18) -> Size:
    """The usual size, as a whole and along each axis a little larger or smaller, at most by `spread`."""
    whole = rng.uniform(1 - 0.6 * spread, 1 + 0.6 * spread)
    depth, width, height = (whole * np.asarray(size_m) * rng.uniform(1 - 0.35 * spread, 1 + 0.35 * spread, 3)).tolist()
    return depth, width, height


def forward(parts: Iterable[Part], offset: Sequence[float]) -> list[Part]:
    """Parts made upright over the origin, tipped so that their top looks out of the object's front, then moved."""
    return placed(parts, offset, rotation=UP_TO_FRONT)


def knob(radius: float, length: float, color: int, at: Sequence[float], segments: int = 14) -> list[Part]:
    """A turning knob on a front, its foot at `at`."""
    profile = [(radius, 0), (0.92 * radius, length), (0.75 * radius, 1.1 * length), (0, 1.1 * length)]
    return forward([lathe(profile, plain(color), segments)], at)


def castors(depth: float, width: float, radius: float, tyre: int = 0x222224) -> list[Part]:
    """Four wheels below the corners."""
    wheel = forward(drum(radius, -0.4 * radius, 0.4 * radius, plain(tyre), plain(0x77797A), 14), (0, 0, 0))
    wheel = placed(wheel, yaw=np.pi / 2)
    corners = [(sx * (depth / 2 - radius), sy * (width / 2 - 0.6 * radius), radius) for sx in (-1, 1) for sy in (-1, 1)]
    return [part for corner in corners for part in placed(wheel, corner)]


def bar(length: float, thickness: float, at: Sequence[float], texture: Texture, stand_off: float) -> list[Part]:
    """A bow handle across a front: a bar, held off by a foot at either end."""
    x, y, z = at
    parts = box((thickness, length, thickness), (x + stand_off, y, z), texture)
    for side in (-1, 1):
        foot = (x + stand_off / 2, y + side * (length - thickness) / 2, z)
        parts += box((stand_off, thickness, thickness), foot, texture)
    return parts
