# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Obstacles whose truth is `unknown`: cones, bollards, crates, pillars, as varied as can be.

A classifier learns from them what has no name, so colour, shape and surface are drawn independently of one another.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.kinds.skins import SIGNAL, STONE, TIMBER, WALL, any_skin, around, banded, warned
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, prism, standing_box
from edgefusion.sim.paint import Extent, Rng
from edgefusion.types import UNKNOWN

TRAFFIC_CONE: Size = (0.42, 0.42, 0.92)
BOLLARD: Size = (0.24, 0.24, 0.95)
CRATE: Size = (0.56, 0.64, 0.68)
PILLAR: Size = (0.38, 0.38, 2.05)


def _polygon(radius: float, sides: int) -> npt.NDArray[np.float64]:
    """A regular outline [sides, 2] with that distance from its middle to its sides, one of them in front."""
    turns = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    return np.asarray(radius / np.cos(np.pi / sides) * np.stack([np.cos(turns), np.sin(turns)], axis=1))


def traffic_cone(rng: Rng) -> list[Part]:
    """A cone or a stouter drum on a rubber foot."""
    _, width, height = varied(rng, TRAFFIC_CONE, 0.25)
    foot = rng.uniform(0.03, 0.06)
    radius = rng.uniform(0.41, 0.46) * width
    tip = rng.uniform(0.2, 0.75) * radius
    color = paint.pick(rng, SIGNAL)
    skin = paint.plastic(rng, (np.pi * radius, height), color)
    skin = warned(rng, skin) if rng.random() < 0.15 else banded(rng, skin, int(rng.integers(0, 4)))
    steps = int(rng.integers(0, 4))  # a drum narrows in steps, a cone evenly
    body = [(radius, foot), (0.94 * radius, foot + 0.04)]
    for i in range(steps):
        share = (i + 1) / (steps + 1)
        r, z = radius + (tip - radius) * share, foot + (height - foot) * share
        body += [(r + 0.012, z), (r - 0.004, z + 0.015)]
    top = 0.0 if rng.random() < 0.5 else 0.05
    body += [(tip, height - top), (0.5 * tip, height - top), (0.4 * tip, height), (0, height)]
    rubber = plain(color if rng.random() < 0.3 else paint.pick(rng, (0x1C1C1E, 0x303234, 0x4A3A30)))
    shape = int(rng.integers(3))
    feet = (
        drum(width / 2, 0, foot, rubber, segments=24),
        prism(_polygon(width / 2, 8), 0, foot, rubber),
        standing_box((width, width, foot), rubber),
    )
    return [*feet[shape], lathe(body, around(skin), 24)]


def _bollard_head(rng: Rng, radius: float, z: float, height: float) -> list[tuple[float, float]]:
    """A profile of what closes a post: flat, a dome, a cone, a ball on a neck."""
    shape = int(rng.integers(4))
    if shape == 0:
        return [(radius, z), (radius, z + height), (0, z + height)]
    if shape == 1:
        return [(radius * float(np.cos(a)), z + height * float(np.sin(a))) for a in np.linspace(0, np.pi / 2, 6)]
    if shape == 2:
        return [(radius, z), (0, z + height)]
    turns = np.linspace(-1.1, np.pi / 2, 8)
    ball = [(0.9 * radius * float(np.cos(a)), z + height * (0.55 + 0.45 * float(np.sin(a)))) for a in turns]
    return [(radius, z), (0.5 * radius, z + 0.04), *ball]


def bollard(rng: Rng) -> list[Part]:
    """A post, round, square or eight-sided, with a head."""
    _, width, height = varied(rng, BOLLARD, 0.25)
    radius, head = width / 2, rng.uniform(0.08, 0.2)
    z = height - head
    sides = int(rng.choice(np.array((0, 0, 4, 8))))
    foot = rng.uniform(0.02, 0.08)
    waist = rng.uniform(0.82, 1.0) * radius
    across = np.pi * radius if sides == 0 else 2 * waist * np.tan(np.pi / sides)
    skin = any_skin(rng, (max(0.12, across), z))
    if rng.random() < 0.4:
        skin = banded(rng, skin, int(rng.integers(1, 4)))
    metal = plain(paint.pick(rng, SIGNAL + STONE))
    if sides == 0:
        parts = [*drum(radius, 0, foot, metal, segments=24), lathe([(waist, foot), (waist, z)], around(skin), 24)]
    else:
        parts = prism(_polygon(radius, sides), 0, foot, metal) + prism(_polygon(waist, sides), foot, z, skin, metal)
    return [*parts, lathe(_bollard_head(rng, waist, z, head), metal, 20)]


def _planked(rng: Rng, size: Extent) -> Texture:
    """Boards with gaps, a frame around, perhaps a brace and a stencil."""
    w, h = size
    color, rows = paint.pick(rng, TIMBER), int(rng.integers(3, 7))
    texture = paint.wood(rng, size, color)
    for i in range(rows):
        board = (0, i * h / rows, w, h / rows)
        marks.inlay(texture, board, paint.toned(texture[: paint.px(h / rows)], rng.uniform(0.85, 1.1)))
        marks.rectangle(texture, (0, i * h / rows, w, rng.uniform(0.004, 0.02)), 0x1A1410)
    beam = rng.uniform(0.05, 0.09)
    if rng.random() < 0.5:
        marks.line(texture, [(beam, h - beam), (w - beam, beam)], paint.lighter(color, 0.85), beam)
    upright = paint.wood(rng, (beam, h), paint.lighter(color, 0.95), True)
    for x in (0, w - beam) if rng.random() < 0.7 else (0.2 * w, 0.8 * w - beam):
        marks.inlay(texture, (x, 0, beam, h), upright)
        for y in (0.1 * h, 0.5 * h, 0.9 * h):
            marks.disc(texture, (x + beam / 2, y), 0.006, 0x2A2622)
    if rng.random() < 0.5:
        words = str(rng.choice(("FRAGILE", "LOT 7", "THIS SIDE UP", "PART 0412", "24 KG")))
        marks.text(texture, words, (1.3 * beam, 0.6 * h), min(0.08, (w - 2.6 * beam) / len(words)), 0x241C18, True)
    return paint.edged(texture, 0.01)


def _cased(rng: Rng, size: Extent) -> Texture:
    """A flight case: panel, metal edges, latches."""
    w, h = size
    texture = paint.grain(rng, paint.flat(size, paint.pick(rng, (0x222428, 0x4A2C22, *SIGNAL, *WALL))), 0.05)
    rim, metal = 0.03, paint.pick(rng, (0xB8BABC, 0x8E9094, 0x303030))
    for rect in ((0, 0, w, rim), (0, h - rim, w, rim), (0, 0, rim, h), (w - rim, 0, rim, h), (0, 0.3 * h, w, rim)):
        marks.rectangle(texture, rect, metal)
        marks.panel(texture, rect, 0.003)
    for x in (0.25 * w, 0.7 * w):
        marks.rectangle(texture, (x, 0.27 * h, 0.08, 0.09), paint.lighter(metal, 0.7))
        marks.panel(texture, (x, 0.27 * h, 0.08, 0.09))
    return paint.dirt(rng, texture, 0.04)


def _moulded(rng: Rng, size: Extent) -> Texture:
    """A plastic box: ribs and grip holes."""
    w, h = size
    texture = paint.plastic(rng, size, paint.pick(rng, SIGNAL))
    ribs = int(rng.integers(3, 9))
    for i in range(ribs):
        marks.panel(texture, (w * (i + 0.1) / ribs, 0.2 * h, 0.8 * w / ribs, 0.72 * h), 0.006, bool(rng.random() < 0.5))
    marks.rectangle(texture, (0.35 * w, 0.06 * h, 0.3 * w, 0.06 * h), 0x141414)
    return paint.edged(texture, 0.015)


def _sheeted(rng: Rng, size: Extent) -> Texture:
    """Plywood, sheet metal or cement, perhaps with warning stripes or a panel."""
    sheets = (paint.wood, paint.brushed_metal, paint.painted_metal, paint.concrete)
    texture = sheets[int(rng.integers(4))](rng, size, paint.pick(rng, TIMBER + STONE + WALL))
    texture = warned(rng, texture) if rng.random() < 0.2 else texture
    if rng.random() < 0.6:
        marks.panel(texture, (0.1 * size[0], 0.1 * size[1], 0.8 * size[0], 0.8 * size[1]), 0.006)
    return paint.edged(texture)


def _one_crate(rng: Rng, size: Size, z: float) -> list[Part]:
    """A closed box in one of the styles, its edges perhaps strengthened."""
    depth, width, height = size
    make = (_planked, _planked, _cased, _moulded, _sheeted)[int(rng.integers(5))]
    wall = make(rng, (width, height))
    if rng.random() < 0.5:
        return standing_box(size, wall, z=z)
    post = plain(paint.pick(rng, (*TIMBER, 0x5A5C60, 0x202224)))
    t = rng.uniform(0.03, 0.06)
    parts = standing_box((depth - t, width - t, height), wall, z=z)
    for x in (-1, 1):
        for y in (-1, 1):
            parts += box((t, t, height), (x * (depth - t) / 2, y * (width - t) / 2, z + height / 2), post)
    return parts


def crate(rng: Rng) -> list[Part]:
    """One large box, or two on one another."""
    depth, width, height = varied(rng, CRATE, 0.25)
    if rng.random() < 0.6:
        return _one_crate(rng, (depth, width, height), 0)
    low = rng.uniform(0.55, 0.68) * height
    upper = _one_crate(rng, (rng.uniform(0.8, 0.95) * depth, rng.uniform(0.8, 0.95) * width, height - low), low)
    return _one_crate(rng, (depth, width, low), 0) + placed(upper, yaw=rng.uniform(-0.08, 0.08))


def pillar(rng: Rng) -> list[Part]:
    """A column, round, square or eight-sided, with or without base and capital."""
    _, width, height = varied(rng, PILLAR, 0.25)
    radius = width / 2
    base, cap = (rng.uniform(0.06, 0.2) if rng.random() < 0.5 else 0.0 for _ in range(2))
    shaft = radius * (rng.uniform(0.85, 0.95) if base or cap else 1.0)
    sides = int(rng.choice(np.array((0, 0, 4, 4, 8))))
    across = np.pi * shaft if sides == 0 else 2 * shaft * np.tan(np.pi / sides)
    skin = any_skin(rng, (across, height - base - cap))
    stone = paint.concrete(rng, (0.3, 0.15), paint.pick(rng, STONE + WALL))
    z0, z1 = base, height - cap
    if sides == 0:
        parts = drum(shaft, z0, z1, around(skin), stone, 28)
    else:
        parts = prism(_polygon(shaft, sides), z0, z1, skin, stone)
    for low, high in ((0.0, base), (z1, height)):
        if high > low:
            parts += prism(_polygon(radius, sides or 12), low, high, stone)
    return parts


KINDS = (
    Kind("traffic cone", UNKNOWN, TRAFFIC_CONE, traffic_cone),
    Kind("bollard", UNKNOWN, BOLLARD, bollard),
    Kind("crate", UNKNOWN, CRATE, crate),
    Kind("pillar", UNKNOWN, PILLAR, pillar),
)
