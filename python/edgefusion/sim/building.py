# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a world is built of: floors, walls, a ceiling or the sky. Each material is one tile, repeated."""

from __future__ import annotations

from typing import Callable, Mapping

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.sim import marks, paint
from edgefusion.sim.mesh import Floats, Part, Texture, plain
from edgefusion.sim.paint import Rng
from edgefusion.sim.world import Wall, World

TILE_M = 2.0
"""A tile's side on the surface; it is painted at half the resolution of objects, which are nearer."""

_DRAWN_M = TILE_M / 2

Finish = Callable[[Rng], Texture]
_SQUARE = (_DRAWN_M, _DRAWN_M)


def _even(colors: tuple[int, ...], grain: float) -> Finish:
    """One colour with a grain and faint blotches: what is strong in a tile shows as a pattern when it is repeated."""

    def painted(rng: Rng) -> Texture:
        texture = paint.grain(rng, paint.flat(_SQUARE, paint.pick(rng, colors, 0.03)), grain)
        return paint.seamless(paint.toned(texture, 1 + 0.02 * paint.clouds(rng, texture.shape[:2], 90)))

    return painted


def _brick(rng: Rng) -> Texture:
    color = paint.pick(rng, (0x8E4B36, 0xA5674C, 0x7B5340, 0xB08A68))
    texture = paint.grain(rng, paint.flat(_SQUARE, 0xB5AFA4), 0.05)
    rows, columns, gap = 14, 5, 0.004
    high, wide = _DRAWN_M / rows, _DRAWN_M / columns
    for row in range(rows):
        for column in range(-1, columns):
            x = (column + 0.5 * (row % 2)) * wide
            shade = paint.lighter(color, float(rng.uniform(0.8, 1.15)))
            marks.rectangle(texture, (max(0, x), row * high, min(wide, wide + x) - gap, high - gap), shade)
    return paint.grain(rng, texture, 0.06)


def _panels(rng: Rng) -> Texture:
    """Wooden boards, upright."""
    texture = paint.wood(rng, _SQUARE, paint.pick(rng, (0x9A7048, 0x7A5236, 0xB08C60)), True)
    for i in range(5):
        x = i * _DRAWN_M / 5
        marks.line(texture, [(x, 0), (x, _DRAWN_M)], 0x3A2A1C, 0.004)
    return texture


def _facade(rng: Rng) -> Texture:
    """A storey of a house, with a window."""
    texture = _brick(rng) if rng.random() < 0.5 else _even((0xC9BFA6, 0xB9A48C, 0xA7ADB0, 0xC4A890), 0.02)(rng)
    marks.rectangle(texture, (0.30, 0.18, 0.40, 0.50), 0xE8E6E0)
    marks.rectangle(texture, (0.33, 0.21, 0.34, 0.44), 0x3C4A58)
    marks.polygon(texture, [(0.33, 0.21), (0.52, 0.21), (0.33, 0.52)], 0x6E8296)
    marks.line(texture, [(0.5, 0.21), (0.5, 0.65)], 0xE8E6E0, 0.018)
    return texture


def _tiles(rng: Rng) -> Texture:
    texture = paint.flat(_SQUARE, 0x77746E)
    count, color = 4, paint.pick(rng, (0xC8C4B8, 0xA8A296, 0x8E9498, 0xB49A80))
    side, gap = _DRAWN_M / count, 0.004
    for row in range(count):
        for column in range(count):
            shade = paint.lighter(color, float(rng.uniform(0.93, 1.06)))
            marks.rectangle(texture, (column * side, row * side, side - gap, side - gap), shade)
    return paint.grain(rng, texture, 0.03)


def _carpet(rng: Rng) -> Texture:
    return paint.grain(rng, paint.flat(_SQUARE, paint.pick(rng, (0x5A6470, 0x6E6458, 0x4E5A50, 0x7A6A5E))), 0.12)


def _linoleum(rng: Rng) -> Texture:
    texture = paint.flat(_SQUARE, paint.pick(rng, (0x9AA39A, 0xA79F8E, 0x8D969C, 0xB3AA98)))
    speckle = paint.clouds(rng, texture.shape[:2], 4.0)
    return paint.seamless(paint.toned(texture, 1 + 0.05 * speckle))


def _parquet(rng: Rng) -> Texture:
    texture = paint.wood(rng, _SQUARE, paint.pick(rng, (0xA67C4E, 0x8A6440, 0xC09A6A)))
    for i in range(8):
        y = i * _DRAWN_M / 8
        marks.line(texture, [(0, y), (_DRAWN_M, y)], 0x4A3422, 0.003)
        x = float(rng.uniform(0, _DRAWN_M))
        marks.line(texture, [(x, y), (x, y + _DRAWN_M / 8)], 0x4A3422, 0.003)
    return texture


_CONCRETE = _even((0x9C9A94, 0x86867F, 0xAAA79F), 0.06)
WALLS: Mapping[str, Finish] = {
    "plaster": _even((0xD9D3C4, 0xCFD4D6, 0xD8CDB6, 0xC2CCC2, 0xE2DED6), 0.02),
    "brick": _brick,
    "panels": _panels,
    "concrete": _CONCRETE,
    "facade": _facade,
}
FLOORS: Mapping[str, Finish] = {
    "linoleum": _linoleum,
    "carpet": _carpet,
    "tiles": _tiles,
    "parquet": _parquet,
    "concrete": _CONCRETE,
    "asphalt": _even((0x5E5E60, 0x6C6A68), 0.14),
}
SKIRTING = 0x6E6A64
_MARGIN_M = 12.0


def wall_parts(wall: Wall, tile: Texture) -> list[Part]:
    """The faces of a wall, its ends and a skirting board."""
    start, end = np.asarray(wall.start), np.asarray(wall.end)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]]) * wall.thickness_m / 2
    corners = [start - across, end - across, end + across, start + across]  # counter-clockwise from above
    board = across * (1 + 0.03 / wall.thickness_m)
    skirting = [start - board, end - board, end + board, start + board]
    parts = []
    for outline, top_m, texture in ((corners, wall.height_m, tile), (skirting, 0.08, plain(SKIRTING))):
        for a, b in zip(outline, outline[1:] + outline[:1]):
            parts.append(_upright(a, b, top_m, texture))
    return parts


def _upright(a: np.ndarray, b: np.ndarray, top_m: float, tile: Texture) -> Part:
    """A face from the ground upwards, its tile repeated; seen from the right of the way from a to b."""
    length = float(np.linalg.norm(b - a))
    vertices = np.array([(*a, top_m), (*b, top_m), (*b, 0), (*a, 0)], np.float32)
    u, v = length / TILE_M, top_m / TILE_M
    uv = np.array([[0, 0], [u, 0], [u, v], [0, v]], np.float32)
    normal = np.array([b[1] - a[1], a[0] - b[0], 0]) / length
    return Part(vertices, np.tile(normal, (4, 1)), uv, np.array([[0, 2, 1], [0, 3, 2]], np.int32), tile)


def _level(world: World, z: float, up: bool, tile: Texture) -> Part:
    """The floor or the ceiling, a margin wider than all walls, in pieces: textures bend on large surfaces."""
    ends = np.array([p for wall in world.walls for p in (wall.start, wall.end)] or [(0.0, 0.0)])
    (x0, y0), (x1, y1) = ends.min(axis=0) - _MARGIN_M, ends.max(axis=0) + _MARGIN_M
    x, y = np.meshgrid(np.arange(x0, x1 + TILE_M, TILE_M), np.arange(y0, y1 + TILE_M, TILE_M))
    corners = np.stack([x, y, np.full_like(x, z)], axis=-1).reshape(-1, 3)
    columns = x.shape[1]
    first = (np.arange(x.shape[0] - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    square = np.stack([first, first + 1, first + columns + 1, first + columns], axis=1)
    faces = np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
    normals = np.tile((0.0, 0.0, 1.0 if up else -1.0), (len(corners), 1))
    uv = corners[:, :2] / TILE_M
    return Part(_f32(corners), _f32(normals), _f32(uv), np.asarray(faces if up else faces[:, ::-1], np.int32), tile)


def _f32(values: npt.ArrayLike) -> Floats:
    return np.asarray(values, np.float32)


def building_parts(world: World) -> list[Part]:
    """Floor, walls and ceiling; worlds of another seed look otherwise."""
    rng = np.random.default_rng(world.seed)
    tiles = {finish: WALLS[finish](rng) for finish in sorted({wall.finish for wall in world.walls})}
    parts = [_level(world, 0.0, True, FLOORS[world.floor](rng))]
    for wall in world.walls:
        parts += wall_parts(wall, tiles[wall.finish])
    if world.ceiling_m is not None:
        parts.append(_level(world, world.ceiling_m, False, plain(paint.pick(rng, (0xE6E4DE, 0xDCDCDA), 0.02))))
    return parts


def sky(width: int, height: int, horizon_px: float) -> Texture:
    """A clear sky down to the horizon's row, BGR [height, width, 3]."""
    up = np.clip(1 - np.arange(height) / max(horizon_px, 1.0), 0, 1)[:, None]
    rows = (1 - up) * np.array([225.0, 215.0, 205.0]) + up * np.array([205.0, 160.0, 110.0])
    return np.asarray(cv2.resize(rows[:, None].astype(np.uint8), (width, height), interpolation=cv2.INTER_NEAREST))
