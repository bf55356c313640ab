# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Textured surfaces, and the few shapes that objects are put together from.

Frame of an object: x forward (out of its front), y left, z up, the origin on the ground under its middle; metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from edgefusion.types import read_only

Floats = npt.NDArray[np.float32]
Texture = npt.NDArray[np.uint8]
"""BGR [height, width, 3]; row 0 is the upper edge of the surface it is put on."""

FACES = ("front", "back", "left", "right", "top", "bottom")
# The corners of each face of the unit cube, upper left first, then clockwise for one who looks at it from outside.
_FACE_CORNERS = {
    "front": ((1, -1, 1), (1, 1, 1), (1, 1, -1), (1, -1, -1)),
    "back": ((-1, 1, 1), (-1, -1, 1), (-1, -1, -1), (-1, 1, -1)),
    "left": ((1, 1, 1), (-1, 1, 1), (-1, 1, -1), (1, 1, -1)),
    "right": ((-1, -1, 1), (1, -1, 1), (1, -1, -1), (-1, -1, -1)),
    "top": ((-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1)),
    "bottom": ((1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, -1)),
}


@dataclass(frozen=True)
class Part:
    """A surface with one texture.

    vertices, normals: float32[n, 3]; uv: float32[n, 2], (0, 0) the texture's upper left; triangles: int32[m, 3],
    counter-clockwise for one who looks at the outside. Raises ValueError where the shapes do not fit.
    """

    vertices: Floats
    normals: Floats
    uv: Floats
    triangles: npt.NDArray[np.int32]
    texture: Texture

    def __post_init__(self) -> None:
        n = len(self.vertices)
        for name, columns in (("vertices", 3), ("normals", 3), ("uv", 2)):
            array = np.asarray(getattr(self, name), np.float32)
            if array.shape != (n, columns):
                raise ValueError(f"{name}: expected shape [{n}, {columns}], got {list(array.shape)}")
            object.__setattr__(self, name, read_only(array))
        triangles = np.asarray(self.triangles, np.int32)
        if triangles.ndim != 2 or triangles.shape[1] != 3 or (triangles < 0).any() or (triangles >= n).any():
            raise ValueError(f"triangles: expected [m, 3] of indices below {n}, got {list(triangles.shape)}")
        if self.texture.dtype != np.uint8 or self.texture.ndim != 3 or self.texture.shape[2] != 3:
            raise ValueError(f"texture: expected uint8 [h, w, 3], got {list(self.texture.shape)}")
        object.__setattr__(self, "triangles", read_only(triangles))
        object.__setattr__(self, "texture", read_only(self.texture))


Parts = Sequence[Part]


def plain(color: int) -> Texture:
    """A texture of one colour, 0xRRGGBB."""
    return np.full((4, 4, 3), (color & 255, color >> 8 & 255, color >> 16 & 255), np.uint8)


def quad(corners: npt.ArrayLike, texture: Texture) -> Part:
    """A flat panel [4, 3]: upper left corner first, then clockwise for one who looks at its front."""
    a = np.asarray(corners, np.float32)
    normal = np.cross(a[3] - a[0], a[1] - a[0])
    normals = np.tile(normal / np.linalg.norm(normal), (4, 1))
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    return Part(a, normals, uv, np.array([[0, 2, 1], [0, 3, 2]], np.int32), texture)


def box(
    size: Sequence[float], centre: Sequence[float], texture: Texture, faces: Mapping[str, Texture] | None = None
) -> list[Part]:
    """A cuboid, size (x, y, z) about its centre; `faces` gives some of FACES a texture of their own."""
    half = np.asarray(size, float) / 2
    own = dict(faces or {})
    if not set(own) <= set(FACES):
        raise ValueError(f"faces: expected some of {', '.join(FACES)}, got {', '.join(own)}")
    return [
        quad(np.asarray(corners) * half + np.asarray(centre, float), own.get(name, texture))
        for name, corners in _FACE_CORNERS.items()
    ]


def standing_box(
    size: Sequence[float], texture: Texture, faces: Mapping[str, Texture] | None = None, z: float = 0.0
) -> list[Part]:
    """A cuboid whose bottom is at height z over the origin."""
    return box(size, (0, 0, z + size[2] / 2), texture, faces)


def lathe(profile: npt.ArrayLike, texture: Texture, segments: int = 32) -> Part:
    """A round body about the z axis. profile [n, 2]: (radius, z), from below; the texture runs around it once,
    its upper edge at the profile's end. Radius 0 at an end closes the body."""
    points = np.asarray(profile, float)
    turns = np.linspace(0, 2 * np.pi, segments + 1)
    along = np.diff(points, axis=0)
    length = np.concatenate([[0], np.cumsum(np.hypot(*along.T))])
    vertices: list[npt.NDArray[np.float64]] = []
    normals: list[npt.NDArray[np.float64]] = []
    uv: list[npt.NDArray[np.float64]] = []
    triangles: list[npt.NDArray[np.int_]] = []
    for i, (dr, dz) in enumerate(along):  # every ring of faces has its own vertices: edges between rings are sharp
        slope = np.hypot(dr, dz)
        if slope == 0:
            continue
        base = len(vertices) * 2 * (segments + 1)
        (r0, z0), (r1, z1) = points[i], points[i + 1]
        c, s = np.cos(turns), np.sin(turns)
        lower = np.stack([r0 * c, r0 * s, np.full_like(c, z0)], axis=1)
        upper = np.stack([r1 * c, r1 * s, np.full_like(c, z1)], axis=1)
        normal = np.stack([c * dz, s * dz, np.full_like(c, -dr)], axis=1) / slope
        vertices.append(np.concatenate([lower, upper]))
        normals.append(np.concatenate([normal, normal]))
        u = turns / (2 * np.pi)
        rows = [np.stack([u, np.full_like(u, 1 - length[k] / length[-1])], axis=1) for k in (i, i + 1)]
        uv.append(np.concatenate(rows))
        a = base + np.arange(segments)
        b = a + segments + 1
        triangles += [np.stack([a, a + 1, b + 1], axis=1), np.stack([a, b + 1, b], axis=1)]
    if not vertices:
        raise ValueError("profile: expected at least two points that differ")
    return Part(
        np.concatenate(vertices).astype(np.float32),
        np.concatenate(normals).astype(np.float32),
        np.concatenate(uv).astype(np.float32),
        np.concatenate(triangles).astype(np.int32),
        texture,
    )


def drum(
    radius: float, z0: float, z1: float, texture: Texture, top: Texture | None = None, segments: int = 32
) -> list[Part]:
    """A closed upright cylinder from z0 to z1."""
    lid = texture if top is None else top
    return [
        lathe([(radius, z0), (radius, z1)], texture, segments),
        lathe([(radius, z1), (0, z1)], lid, segments),
        lathe([(0, z0), (radius, z0)], lid, segments),
    ]


def prism(outline: npt.ArrayLike, z0: float, z1: float, side: Texture, top: Texture | None = None) -> list[Part]:
    """An upright body over a convex outline [n, 2], counter-clockwise from above; the texture is on every side."""
    points = np.asarray(outline, float)
    n = len(points)
    walls = []
    for a, b in zip(points, np.roll(points, -1, axis=0)):
        walls.append(quad([(*a, z1), (*b, z1), (*b, z0), (*a, z0)], side))
    fan = np.array([[0, i, i + 1] for i in range(1, n - 1)])
    low, high = points.min(axis=0), points.max(axis=0)
    uv = (points - low) / np.maximum(high - low, 1e-9)
    for z, up in ((z1, 1.0), (z0, -1.0)):
        vertices = np.column_stack([points, np.full(n, z)])
        normals = np.tile((0.0, 0.0, up), (n, 1))
        lid = side if top is None else top
        faces = np.asarray(fan if up > 0 else fan[:, ::-1], np.int32)
        walls.append(Part(vertices.astype(np.float32), normals.astype(np.float32), uv.astype(np.float32), faces, lid))
    return walls


def placed(
    parts: Iterable[Part], offset: Sequence[float] = (0, 0, 0), yaw: float = 0.0, rotation: npt.ArrayLike | None = None
) -> list[Part]:
    """Parts turned by `rotation` [3, 3] (or about z by yaw [rad]), then moved."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) if rotation is None else np.asarray(rotation, float)
    return [
        replace(
            part,
            vertices=(part.vertices @ R.T + np.asarray(offset, float)).astype(np.float32),
            normals=(part.normals @ R.T).astype(np.float32),
        )
        for part in parts
    ]


def scaled(parts: Iterable[Part], factors: Sequence[float]) -> list[Part]:
    """Parts stretched along x, y, z about the origin."""
    stretch = np.asarray(factors, float)
    if (stretch <= 0).any():
        raise ValueError(f"factors: expected above 0, got {list(factors)}")
    done = []
    for part in parts:
        normals = part.normals / stretch
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        vertices = (part.vertices * stretch).astype(np.float32)
        done.append(replace(part, vertices=vertices, normals=normals.astype(np.float32)))
    return done


def size_of(parts: Iterable[Part]) -> npt.NDArray[np.float64]:
    """Extent [3] along x, y, z."""
    vertices = np.concatenate([part.vertices for part in parts]).astype(float)
    extent: npt.NDArray[np.float64] = vertices.max(axis=0) - vertices.min(axis=0)
    return extent
