# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Surfaces of obstacles without a name: any material, and what is painted or stuck on it."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.mesh import Texture
from edgefusion.sim.paint import Extent, Rng

SIGNAL = (0xF0641E, 0xE8451A, 0xF2C21C, 0xC8D82A, 0xC81E1E, 0x1E62B4, 0xECECE8, 0x2E9A48, 0x303234)
STONE = (0x9A9A96, 0xB4B0A6, 0x7C7E80, 0xC8C0B0, 0xA08C78)
WALL = (0xE4DED0, 0xD0D4D6, 0xC8B898, 0x8FA8A0, 0xB86A50, 0x5A6A80)
TIMBER = (0xB08858, 0x8C6238, 0xC8A878, 0x6A4A30, 0x7A7468)


def banded(rng: Rng, texture: Texture, count: int) -> Texture:
    """Reflecting bands around."""
    h, w = (n / paint.PX_PER_M for n in texture.shape[:2])
    color = paint.pick(rng, (0xF4F4F0, 0xF4F4F0, 0xD0D4D8, 0xF2C21C, 0xC81E1E, 0x202020))
    height = rng.uniform(0.06, 0.14) * h
    for i in range(count):
        y = h * (0.16 + 0.6 * (i + rng.uniform(0, 0.2)) / count)
        marks.rectangle(texture, (0, y, w, height), color)
        marks.line(texture, [(0, y), (w, y)], paint.lighter(color, 0.6), 0.004)
    return texture


def warned(rng: Rng, texture: Texture) -> Texture:
    """Slanting warning stripes, all over or in one band."""
    h, w = (n / paint.PX_PER_M for n in texture.shape[:2])
    low, high = (0.0, h) if rng.random() < 0.4 else (rng.uniform(0.1, 0.4) * h, rng.uniform(0.6, 1) * h)
    light, dark = ((0xF2C21C, 0x181818), (0xF0F0EC, 0xC81E1E), (0xF0F0EC, 0x2A62A8))[int(rng.integers(3))]
    rect = (0.0, low, w, high - low)
    marks.rectangle(texture, rect, light)
    marks.hatched(texture, rect, dark, rng.uniform(0.06, 0.16), rng.uniform(0.5, 1.2) * rng.choice((-1, 1)))
    return paint.dirt(rng, texture, 0.05)


def _posted(rng: Rng, texture: Texture) -> Texture:
    """Notices stuck on anyhow."""
    h, w = (n / paint.PX_PER_M for n in texture.shape[:2])
    for _ in range(int(rng.integers(1, 4))):
        across, down = rng.uniform(0.4, 0.8) * w, rng.uniform(0.08, 0.2) * h
        x, y = rng.uniform(0, w - across), rng.uniform(0.05, 0.7) * h
        marks.rectangle(texture, (x, y, across, down), paint.pick(rng, (0xF2F0E8, 0xE8D84A, 0x50A0C8, 0xD85848)))
        for i in range(int(rng.integers(2, 6))):
            line_y = y + down * (0.2 + 0.12 * i)
            marks.line(texture, [(x + 0.1 * across, line_y), (x + rng.uniform(0.5, 0.9) * across, line_y)], 0x303030)
    return texture


def _two_coloured(rng: Rng, texture: Texture) -> Texture:
    """The lower part in another colour, a number above."""
    h, w = (n / paint.PX_PER_M for n in texture.shape[:2])
    top = rng.uniform(0.35, 0.75) * h
    color = paint.pick(rng, SIGNAL)
    marks.rectangle(texture, (0, top, w, h - top), color)
    words = str(rng.choice(("P2", "A", "C 14", "7", "B3", "12")))
    marks.text(texture, words, (0.2 * w, top - 0.06), rng.uniform(0.06, 0.12), paint.lighter(color, 0.7), True)
    return paint.dirt(rng, texture, 0.04)


def any_skin(rng: Rng, size: Extent) -> Texture:
    """The surface of something that stands about: any material, often with something painted or stuck on."""
    material = int(rng.integers(7))
    if material == 0:
        texture = paint.concrete(rng, size, paint.pick(rng, STONE))
    elif material == 1:
        stone = (rng.uniform(0.16, 0.26), rng.uniform(0.06, 0.09))
        texture = paint.masonry(rng, size, paint.pick(rng, (0x9C4A34, 0xB8785A, 0x8A8078, 0xC8B48C)), 0xB0A898, stone)
    elif material == 2:
        side = rng.uniform(0.08, 0.2)
        texture = paint.masonry(rng, size, paint.pick(rng, WALL + SIGNAL), 0xD8D8D4, (side, side), 0)
    elif material == 3:
        texture = paint.marble(rng, size, paint.pick(rng, STONE + WALL))
    elif material == 4:
        texture = paint.wood(rng, size, paint.pick(rng, TIMBER), True)
    elif material == 5:
        texture = paint.brushed_metal(rng, size, paint.pick(rng, (0xB4B6B8, 0x8A8C90, 0xA88A5A)))
    else:
        texture = paint.dirt(rng, paint.grain(rng, paint.flat(size, paint.pick(rng, WALL + SIGNAL)), 0.03), 0.06)
    finish = (None, None, warned, _posted, _two_coloured, None)[int(rng.integers(6))]
    return finish(rng, texture) if finish is not None else texture


def around(texture: Texture) -> Texture:
    """A texture of half a turn, put around twice."""
    return np.concatenate([texture, texture], axis=1)
