# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is kept in a store room."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import forward, knob, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.kinds.skins import around
from edgefusion.sim.mesh import Part, Texture, box, lathe, placed, plain, standing_box
from edgefusion.sim.paint import Rng

WASHER: Size = (0.58, 0.60, 0.88)
BARREL: Size = (0.62, 0.62, 0.92)
SAFE: Size = (0.55, 0.58, 0.80)


def _porthole(rng: Rng, radius: float) -> list[Part]:
    """A washer's door, z = 0 on its front: a bright ring, a bulging pane, the drum behind it."""
    ring = 0xC8CCD0 if rng.random() < 0.7 else paint.pick(rng, (0xF0F0F0, 0x4A4E52))
    glass = paint.flat((0.6, 0.2), 0x5A646C)
    for x in np.arange(0.01, 0.6, 0.03):
        for y in (0.03, 0.07, 0.11):
            marks.disc(glass, (float(x), y), 0.005, 0x20262C)
    across = np.linspace(0, 2 * np.pi, glass.shape[1], dtype=np.float32)[None, :]
    glass = paint.toned(glass, 0.75 + 0.5 * np.exp(-(((across - rng.uniform(2, 4)) / 0.5) ** 2)))
    frame = [(1.2, 0.0), (1.18, 0.02), (1.08, 0.035), (0.88, 0.03), (0.8, 0.012)]
    pane = [(0.8, 0.012), (0.68, 0.03), (0.5, 0.02), (0.3, 0.005), (0.0, 0.0)]
    return [
        lathe(np.array(frame) * (radius, 1), plain(ring), 36),
        lathe(np.array(pane) * (radius, 1), glass, 36),
    ]


def washer(rng: Rng) -> list[Part]:
    """A front loader: a round glass door, a drawer for the powder, a dial."""
    depth, width, height = varied(rng, WASHER, 0.12)
    depth -= 0.045  # the door stands out
    color = paint.pick(rng, (0xF4F4F2, 0xF0F2F2, 0xF4F4F2, 0xD4D8DC, 0xECE8DC), 0.015)
    sheet = paint.shaded(paint.grain(rng, paint.flat((width, height), color), 0.01), 1.0, 0.92)
    face = sheet.copy()
    panel = rng.uniform(0.14, 0.17) * height
    marks.rectangle(face, (0, 0, width, panel), paint.lighter(color, rng.choice((0.86, 0.96, 0.4))))
    marks.line(face, [(0, panel), (width, panel)], 0x8A8C8E, 0.004)
    marks.rectangle(face, (0.02, 0.02, 0.3 * width, panel - 0.035), color)
    marks.panel(face, (0.02, 0.02, 0.3 * width, panel - 0.035), 0.004)
    marks.rectangle(face, (0.09 * width, 0.6 * panel, 0.15 * width, 0.012), 0x9A9EA2)
    marks.text(
        face,
        str(rng.choice(("AQUA 7", "LAVANDA", "WASH-O", "1200 rpm"))),
        (0.06 * width, 0.45 * panel),
        0.016,
        0x3050A0,
    )
    marks.dial(face, (0.5 * width, panel / 2), 0.036, rng.uniform(2.5, 7), 0xC8CACC)
    marks.rectangle(face, (0.63 * width, 0.28 * panel, 0.15 * width, 0.44 * panel), 0x10202A)
    marks.text(face, str(rng.choice(("0:45", "1:20", "2:05"))), (0.65 * width, 0.62 * panel), 0.022, 0x60D8F0)
    for i in range(3):
        marks.rings(face, ((0.83 + 0.055 * i) * width, panel / 2), [(0.012, 0x707478), (0.010, 0xF8F8F8)])
    marks.panel(face, (0.06 * width, height - 0.11, 0.25 * width, 0.08), 0.003)
    radius, z = rng.uniform(0.29, 0.33) * width, rng.uniform(0.45, 0.5) * height
    for reach, gain in ((1.36, 0.97), (1.32, 0.92), (1.28, 0.85), (1.24, 0.76)):
        marks.disc(face, (width / 2, height - z + 0.012), reach * radius, paint.lighter(color, 0.95 * gain))
    parts = standing_box((depth, width, height), sheet, {"front": face})
    parts += forward(_porthole(rng, radius), (depth / 2, 0, z))
    side = float(rng.choice((-1, 1)))
    return parts + box((0.03, 0.035, 0.10), (depth / 2 + 0.03, side * 1.02 * radius, z), plain(0x8A8E92))


def _staves(rng: Rng, across: float, height: float) -> Texture:
    """A barrel's planks and hoops, half of them around."""
    color = paint.pick(rng, (0x9A6E44, 0xA87C50, 0x7A5434, 0x8A7058))
    staves = paint.wood(rng, (across, height), color, True)
    count = int(rng.integers(10, 15))
    step = across / count
    for i in range(count):
        strip = staves[:, paint.px(i * step) : paint.px((i + 1) * step)]
        strip[:] = paint.toned(strip, rng.uniform(0.82, 1.12))
        marks.line(staves, [(i * step, 0), (i * step, height)], paint.lighter(color, 0.55), 0.003)
    marks.disc(staves, (0.5 * step + step * int(rng.integers(count)), 0.5 * height), 0.03, 0x3A2414)
    staves = paint.dirt(rng, staves, 0.1)
    iron = paint.pick(rng, (0x3A3C40, 0x54504C, 0x6A5040))
    for y in (0.0, 0.11, 0.27):
        for top in (y * height, (0.945 - y) * height):
            marks.rectangle(staves, (0, top, across, 0.055 * height), iron)
            marks.rectangle(staves, (0, top, across, 0.008 * height), paint.lighter(iron, 1.5))
            marks.rectangle(staves, (0, top + 0.055 * height, across, 0.006 * height), 0x1C120A)
    return paint.shaded(staves, 1.1, 0.8)


def barrel(rng: Rng) -> list[Part]:
    """Bulging staves, iron hoops, a bung."""
    _, width, height = varied(rng, BARREL)
    staves = around(_staves(rng, 0.5 * np.pi * width, height))
    z = np.linspace(0, 1, 11)
    narrow = rng.uniform(0.74, 0.82)
    bulge = 0.5 * width * (narrow + (1 - narrow) * np.sin(np.pi * z))
    lid = paint.wood(rng, (0.5, 0.5), paint.pick(rng, (0x9A6E44, 0x7A5434)))
    parts = [lathe(np.stack([bulge, z * height], axis=1), staves, 28)]
    top = [(bulge[-1], height), (0.93 * bulge[-1], height), (0.93 * bulge[-1], height - 0.03), (0, height - 0.03)]
    return [*parts, lathe(top, lid, 28), lathe([(0, 0), (bulge[0], 0)], lid, 28)]


def _wheel(at: tuple[float, float, float], start: float) -> list[Part]:
    """Six spokes with balls at their ends, on a hub at `at`."""
    x, y, z = at
    steel = plain(0xC8CCD0)
    ball = [(0.013 * float(np.cos(t)), 0.09 + 0.013 * float(np.sin(t))) for t in np.linspace(-np.pi / 2, np.pi / 2, 6)]
    parts = knob(0.03, 0.045, 0xB0B4B8, at)
    for angle in start + np.arange(6) * np.pi / 3:
        c, s = float(np.cos(angle)), float(np.sin(angle))
        spoke = [*box((0.01, 0.01, 0.09), (0, 0, 0.045), steel), lathe(ball, steel, 10)]
        parts += placed(spoke, (x + 0.035, y, z), rotation=((1, 0, 0), (0, c, -s), (0, s, c)))
    return parts


def _lever(at: tuple[float, float, float], length: float) -> list[Part]:
    """A handle that turns about a hub at `at`, pointing right."""
    x, y, z = at
    steel = plain(0xC8CCD0)
    return knob(0.032, 0.03, 0xB0B4B8, at) + box((0.016, length, 0.026), (x + 0.03, y - 0.3 * length, z), steel)


def _keypad(face: Texture, at: tuple[float, float]) -> None:
    """A code lock: display and twelve keys, its upper left corner at `at`."""
    x, y = at
    marks.rectangle(face, (x, y, 0.15, 0.22), 0x141618)
    marks.rectangle(face, (x + 0.015, y + 0.015, 0.12, 0.035), 0x184028)
    marks.text(face, "8888", (x + 0.03, y + 0.045), 0.024, 0x50F080)
    for i in range(12):
        marks.button(face, (x + 0.02 + 0.04 * (i % 3), y + 0.065 + 0.037 * (i // 3), 0.03, 0.026), 0xD0D4D8)


def safe(rng: Rng) -> list[Part]:
    """A steel box with a thick door, hinges, a dial or a keypad, a wheel or a lever."""
    depth, width, height = varied(rng, SAFE, 0.14)
    depth -= 0.045  # the lock stands out
    color = paint.pick(rng, (0x3C4A44, 0x3A3E44, 0x5A5E62, 0x6E2A24, 0x24344A, 0x8A8674, 0xB0B2AE))
    steel = paint.painted_metal(rng, (width, height), color)
    face = steel.copy()
    marks.panel(face, (0.05, 0.05, width - 0.10, height - 0.12), 0.012)
    marks.panel(face, (0.065, 0.065, width - 0.13, height - 0.15), 0.004)
    marks.frame(face, (0.10, 0.10, width - 0.20, height - 0.22), 0xC8A850 if rng.random() < 0.5 else 0x8A8E90, 0.004)
    marks.label(face, str(rng.choice(("SECUR", "FORT", "TRESOR"))), (width / 2 - 0.07, 0.13, 0.14, 0.035), 0xC8A850)
    z, lock = rng.uniform(0.46, 0.56) * height, (-0.16 * width, 0.18 * width)
    parts = standing_box((depth, width, height), steel, {"front": face})
    if rng.random() < 0.5:
        _keypad(face, (width / 2 + lock[0] - 0.075, height - z - 0.11))
    else:
        marks.dial(face, (width / 2 + lock[0], height - z), 0.055, rng.uniform(0, 6), 0x1A1A1C, 0xE8E8E8)
        parts += knob(0.04, 0.03, 0xA8ACB0, (depth / 2, lock[0], z), 20)
    hub = (depth / 2, lock[1], z)
    parts += _wheel(hub, rng.uniform(0, 1)) if rng.random() < 0.5 else _lever(hub, rng.uniform(0.11, 0.15))
    for share in (0.27, 0.82):
        parts += box((0.03, 0.03, 0.1), (depth / 2 + 0.012, -(width / 2 - 0.03), share * height), plain(0x9A9EA2))
    return parts


KINDS = (
    Kind("washer", "washer", WASHER, washer),
    Kind("barrel", "barrel", BARREL, barrel),
    Kind("safe", "safe", SAFE, safe),
)
