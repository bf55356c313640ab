# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A car's body: one skin lofted over cross-sections, to be painted from every side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.sim.kinds.form import varied
from edgefusion.sim.kinds.kind import Size
from edgefusion.sim.mesh import Part, Texture
from edgefusion.sim.paint import Rng

CAR: Size = (4.2, 1.86, 1.5)
MIRROR = 0.07
"""How far the mirrors stand out on either side [m]."""

Points = npt.NDArray[np.float64]


@dataclass(frozen=True)
class BodyShape:
    """A car's side view: heights [m], and places along its length, from -1 at the tail to 1 at the nose."""

    size: Size
    sill: float
    belt: float
    nose: float
    hood_end: float
    roof_start: float
    roof_end: float
    tail: float
    wheel: float
    axles: tuple[float, float]


def body_shape(rng: Rng) -> BodyShape:
    """Estate car, van or hatchback: the longer the roof, the steeper the tail."""
    depth, width, height = varied(rng, CAR, 0.1)
    width -= 2 * MIRROR
    height *= rng.uniform(0.95, 1.06)
    hood_end = rng.uniform(0.36, 0.5)
    roof_end = rng.uniform(-0.82, -0.62)
    wheel = rng.uniform(0.2, 0.215) * height
    return BodyShape(
        size=(depth, width, height),
        sill=0.13 * height,
        belt=rng.uniform(0.6, 0.63) * height,
        nose=rng.uniform(0.5, 0.54) * height,
        hood_end=hood_end,
        roof_start=hood_end - rng.uniform(0.3, 0.36),
        roof_end=roof_end,
        tail=max(-0.97, roof_end - rng.uniform(0.16, 0.3)),
        wheel=wheel,
        axles=(rng.uniform(0.56, 0.62), -rng.uniform(0.56, 0.62)),
    )


def _ring(x: float, half: float, low: float, belt: float, top: float, roof: float) -> Points:
    """One cross-section [13, 3], from right to left over the top; `roof`: half the width up there."""
    mid = low + 0.45 * (belt - low)
    shoulder = belt + 0.12 * (top - belt)
    side = [
        (0.88 * half, low), (0.98 * half, low + 0.2 * (mid - low)), (half, mid), (0.97 * half, belt),
        (0.93 * half + 0.07 * (roof - 0.93 * half), shoulder), (roof, top - 0.06 * (top - low)),
    ]  # fmt: skip
    right = [(x, -y, z) for y, z in side]
    return np.array([*right, (x, 0, top), *[(x, y, z) for y, z in reversed(side)]])


def _rings(shape: BodyShape) -> Points:
    """All cross-sections [n, 13, 3], from the tail to the nose."""
    depth, width, height = shape.size
    half, belt, low = width / 2, shape.belt, shape.sill
    cabin, hood = 0.74 * half, 0.86 * half
    rear = 0.98 * belt
    sections = (
        (-1.0, 0.5 * half, low + 0.1, 0.5 * height, 0.52 * height, 0.42 * half),
        (-0.99, 0.86 * half, low + 0.09, 0.52 * height, 0.55 * height, 0.75 * half),
        (-0.97, 0.95 * half, low + 0.04, rear - 0.05, rear, 0.84 * half),
        (shape.tail, 0.96 * half, low + 0.03, rear, rear + 0.01, 0.84 * half),
        (shape.roof_end, half, low, belt, 0.975 * height, cabin),
        (0.5 * (shape.roof_end + shape.roof_start), half, low, belt, height, cabin),
        (shape.roof_start, half, low, belt, 0.98 * height, cabin),
        (shape.hood_end, half, low, belt, belt + 0.02, hood),
        (0.5 * (shape.hood_end + 0.95), 0.99 * half, low, belt - 0.03, belt + 0.005, hood),
        (0.88, 0.95 * half, low + 0.02, shape.nose - 0.02, shape.nose + 0.02, 0.8 * half),
        (0.94, 0.92 * half, low + 0.03, shape.nose - 0.06, shape.nose - 0.02, 0.76 * half),
        (0.98, 0.82 * half, low + 0.06, shape.nose - 0.12, shape.nose - 0.08, 0.68 * half),
        (1.0, 0.5 * half, low + 0.08, shape.nose - 0.16, shape.nose - 0.14, 0.4 * half),
    )
    return np.array([_ring(x * depth / 2, *others) for x, *others in sections])


def _skin(rings: Points) -> tuple[Points, Points, npt.NDArray[np.int32]]:
    """Vertices, smooth normals, triangles of the surface over the rings, closed below and at both ends."""
    n, m = rings.shape[:2]
    vertices = rings.reshape(-1, 3)
    at = np.arange(n * m).reshape(n, m)
    a, b, c, d = at[:-1], np.roll(at, -1, axis=1)[:-1], np.roll(at, -1, axis=1)[1:], at[1:]
    corners = [np.stack(trio, axis=-1).reshape(-1, 3) for trio in ((a, c, b), (a, d, c))]
    fan = np.array([(0, i, i + 1) for i in range(1, m - 1)])
    triangles = np.concatenate([*corners, at[0][fan], at[-1][fan[:, ::-1]]])
    p = vertices[triangles]
    facets = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    normals = np.zeros_like(vertices)
    for corner in triangles.T:
        np.add.at(normals, corner, facets)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    return vertices, normals, triangles.astype(np.int32)


def painted(shape: BodyShape, textures: dict[str, Texture]) -> list[Part]:
    """The skin cut by where its facets look, each piece painted as it is seen from there."""
    vertices, normals, triangles = _skin(_rings(shape))
    p = vertices[triangles]
    facing = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-9)
    depth, width, height = shape.size
    x, y, z = (vertices / (depth, width, height) + (0.5, 0.5, 0)).T
    views = {  # (u, v) of each vertex, how much a facet looks that way
        "front": (y, 1 - z, facing[:, 0] * 1.9), "back": (1 - y, 1 - z, -facing[:, 0] * 1.9),
        "left": (1 - x, 1 - z, facing[:, 1] * 1.4), "right": (1 - x, 1 - z, -facing[:, 1] * 1.4),
        "top": (y, 1 - x, facing[:, 2]), "bottom": (y, 1 - x, -facing[:, 2]),
    }  # fmt: skip
    best = np.argmax([look for _, _, look in views.values()], axis=0)
    parts = []
    for i, (name, (u, v, _)) in enumerate(views.items()):
        used, index = np.unique(triangles[best == i], return_inverse=True)
        uv = np.stack([u, v], axis=1)[used]
        pieces = (vertices[used].astype(np.float32), normals[used].astype(np.float32), uv.astype(np.float32))
        parts.append(Part(*pieces, index.reshape(-1, 3).astype(np.int32), textures[name]))
    return parts
