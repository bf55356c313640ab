# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is kept in a store room, or stands where things are sold."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import forward, knob, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, box, lathe, placed, plain, standing_box
from edgefusion.sim.paint import Rng

WASHER: Size = (0.58, 0.60, 0.88)
BARREL: Size = (0.62, 0.62, 0.92)
SAFE: Size = (0.55, 0.58, 0.80)
VENDING_MACHINE: Size = (0.78, 0.92, 1.82)
CASH_MACHINE: Size = (0.60, 0.62, 1.45)


def washer(rng: Rng) -> list[Part]:
    """A front loader: a round glass door, a drawer for the powder, a dial."""
    depth, width, height = varied(rng, WASHER, 0.12)
    color = paint.pick(rng, (0xEEEEEA, 0xE4E6E6, 0xC8CCD0, 0xDCD8CC), 0.02)
    sheet = paint.painted_metal(rng, (width, height), color)
    face = sheet.copy()
    panel = 0.15 * height
    marks.rectangle(face, (0, 0, width, panel), paint.lighter(color, 0.93))
    marks.line(face, [(0, panel), (width, panel)], 0x8A8C8E, 0.004)
    marks.panel(face, (0.02, 0.02, 0.3 * width, panel - 0.03), 0.004)
    marks.dial(face, (0.55 * width, panel / 2), 0.035, rng.uniform(2.5, 7), 0xB8BABC)
    marks.rectangle(face, (0.68 * width, 0.3 * panel, 0.13 * width, 0.4 * panel), 0x18202A)
    for i in range(3):
        marks.disc(face, ((0.85 + 0.05 * i) * width, panel / 2), 0.009, 0xF8F8F8)
    marks.panel(face, (0.03, height - 0.13, width - 0.06, 0.10), 0.004)
    radius, z = 0.31 * width, 0.47 * height
    marks.disc(face, (width / 2, height - z), 1.12 * radius, paint.lighter(color, 0.75))
    parts = standing_box((depth, width, height), sheet, {"front": face})
    ring = plain(0xD0D4D8 if rng.random() < 0.6 else 0x3A3E42)
    glass = paint.flat((0.3, 0.2), 0x2A3238)
    glass = paint.toned(glass, np.linspace(2.2, 0.5, glass.shape[0], dtype=np.float32)[:, None])
    door = [(1.1, 0), (1.1, 0.03), (0.98, 0.045), (0.8, 0.035)]
    pane = [(0.8, 0.035), (0.55, 0.0), (0.0, -0.02)]
    parts += forward([lathe(np.array(door) * (radius, 1), ring, 36)], (depth / 2, 0, z))
    parts += forward([lathe(np.array(pane) * (radius, 1), glass, 36)], (depth / 2 + 0.021, 0, z))
    return parts + box((0.03, 0.03, 0.11), (depth / 2 + 0.045, -0.98 * radius, z), plain(0x5A5E62))


def barrel(rng: Rng) -> list[Part]:
    """Bulging staves, iron hoops, sometimes a bung."""
    _, width, height = varied(rng, BARREL)
    color = paint.pick(rng, (0x7A4E2C, 0x8E6238, 0x5E3C22, 0xA0764A))
    around = np.pi * width
    staves = paint.wood(rng, (around, height), color, True)
    count = int(rng.integers(18, 26))
    for i in range(count):
        x = i * around / count
        marks.line(staves, [(x, 0), (x, height)], 0x24160C, 0.005)
        marks.rectangle(
            staves, (x + 0.004, 0, 0.4 * around / count, height), paint.lighter(color, rng.uniform(0.9, 1.12))
        )
    staves = paint.grain(rng, paint.shaded(staves, 1.1, 0.8), 0.06)
    iron = 0x3A3C40 if rng.random() < 0.7 else 0x7A5A44
    for y in (0.02, 0.17, 0.34, 0.62, 0.79, 0.94):
        marks.rectangle(staves, (0, y * height, around, 0.045 * height), iron)
        marks.rectangle(staves, (0, y * height, around, 0.008 * height), paint.lighter(iron, 1.6))
    z = np.linspace(0, 1, 11)
    bulge = 0.5 * width * (0.80 + 0.20 * np.sin(np.pi * z))
    lid = paint.wood(rng, (0.5, 0.5), paint.lighter(color, 0.9))
    parts = [lathe(np.stack([bulge, z * height], axis=1), staves, 28)]
    top = [(bulge[-1], height), (0.93 * bulge[-1], height), (0.93 * bulge[-1], height - 0.03), (0, height - 0.03)]
    return [*parts, lathe(top, lid, 28), lathe([(0, 0), (bulge[0], 0)], lid, 28)]


def safe(rng: Rng) -> list[Part]:
    """A steel box with a thick door, a combination dial, a wheel or a lever, and hinges."""
    depth, width, height = varied(rng, SAFE, 0.14)
    color = paint.pick(rng, (0x3C4A44, 0x2E3238, 0x5A5E62, 0x6E2A24, 0x24344A, 0x7A7464))
    steel = paint.painted_metal(rng, (width, height), color)
    face = steel.copy()
    marks.panel(face, (0.05, 0.05, width - 0.10, height - 0.12), 0.01)
    marks.frame(face, (0.09, 0.09, width - 0.18, height - 0.20), 0xC8A850 if rng.random() < 0.5 else 0x8A8E90, 0.006)
    marks.label(face, str(rng.choice(("SECUR", "FORT", "TRESOR"))), (width / 2 - 0.08, 0.12, 0.16, 0.04), 0xC8A850)
    z = 0.52 * height
    marks.dial(face, (0.36 * width, height - z), 0.055, rng.uniform(0, 6), 0x1A1A1C, 0xE8E8E8)
    parts = standing_box((depth, width, height), steel, {"front": face})
    parts += knob(0.05, 0.03, 0xA8ACB0, (depth / 2, (0.36 - 0.5) * width, z), 20)
    hub = (depth / 2, 0.18 * width, z)
    parts += knob(0.022, 0.05, 0xC8CCD0, hub)
    for turn in range(3):
        angle = turn * 2 * np.pi / 3 + rng.uniform(0, 2)
        c, s = np.cos(angle), np.sin(angle)
        rotation = ((1, 0, 0), (0, c, -s), (0, s, c))
        spoke = box((0.014, 0.014, 0.2), (0, 0, 0), plain(0xC8CCD0))
        parts += placed(spoke, (hub[0] + 0.045, hub[1], hub[2]), rotation=rotation)
    for up in (0.2, 0.75):
        parts += box((0.03, 0.03, 0.1), (depth / 2 + 0.012, -(width / 2 - 0.03), (up + 0.05) * height), plain(0x9A9EA2))
    return parts


def vending_machine(rng: Rng) -> list[Part]:
    """Rows of cans and bars behind glass, a column with a slot and keys, a flap below."""
    depth, width, height = varied(rng, VENDING_MACHINE, 0.12)
    color = paint.pick(rng, (0xB01C20, 0x1C3C8A, 0x202226, 0x1C7A4A, 0xD8D8D8, 0xC85A18))
    shell = paint.plastic(rng, (width, height), color)
    face = shell.copy()
    banner = (0.03, 0.03, width - 0.06, 0.14 * height)
    marks.rectangle(face, banner, paint.lighter(color, 1.5))
    words = str(rng.choice(("COLD DRINKS", "SNACKS", "FRESH", "DRINKS & SNACKS")))
    marks.text(face, words, (0.08, 0.11 * height), min(0.08, 0.85 * width / len(words)), 0xFFFFFF, bold=True)
    glass = (0.05, 0.19 * height, 0.66 * width, 0.58 * height)
    marks.rectangle(face, glass, 0x1A1C20)
    rows, columns = int(rng.integers(5, 7)), int(rng.integers(5, 8))
    for row in range(rows):
        shelf = glass[1] + (row + 1) * glass[3] / rows
        for column in range(columns):
            wide, tall = glass[2] / columns, glass[3] / rows
            x = glass[0] + column * wide
            item = paint.pick(rng, (0xC82828, 0x2848C8, 0xE8C020, 0x28A048, 0xE87820, 0xF0F0F0, 0x7A3CA0))
            top = shelf - tall * rng.uniform(0.62, 0.78)
            marks.rectangle(face, (x + 0.14 * wide, top, 0.72 * wide, shelf - 0.02 - top), item)
            marks.rectangle(face, (x + 0.2 * wide, top + 0.3 * tall, 0.6 * wide, 0.1 * tall), paint.lighter(item, 1.6))
            marks.rectangle(face, (x + 0.14 * wide, top, 0.14 * wide, shelf - 0.02 - top), paint.lighter(item, 1.3))
        marks.rectangle(face, (glass[0], shelf - 0.02, glass[2], 0.02), 0xB8BCC0)
    marks.frame(face, glass, 0x909498, 0.012)
    side = 0.05 + glass[2] + 0.03
    marks.rectangle(face, (side, glass[1], width - side - 0.04, glass[3]), 0x2A2C30)
    marks.rectangle(face, (side + 0.02, glass[1] + 0.05, width - side - 0.08, 0.06), 0x60E0A0)
    for i in range(12):
        at = (side + 0.02 + 0.045 * (i % 3), glass[1] + 0.16 + 0.045 * (i // 3), 0.03, 0.03)
        marks.button(face, at, 0xC8CACC)
    marks.rectangle(face, (side + 0.05, glass[1] + 0.42, 0.06, 0.012), 0xD8DADC)
    marks.rectangle(face, (side + 0.03, glass[1] + 0.5, 0.10, 0.06), 0x101214)
    flap = (0.10, 0.83 * height, 0.58 * width, 0.10 * height)
    marks.panel(face, flap, 0.008, raised=False)
    marks.rectangle(face, (flap[0] + 0.01, flap[1] + 0.01, flap[2] - 0.02, flap[3] - 0.02), 0x17181A)
    return standing_box((depth, width, height), shell, {"front": paint.edged(face, 0.01, 0.3)})


def cash_machine(rng: Rng) -> list[Part]:
    """A free-standing machine: a head with screen and keys that leans back over a narrower safe."""
    depth, width, height = varied(rng, CASH_MACHINE, 0.12)
    color = paint.pick(rng, (0x24508A, 0xA8ACB0, 0x3A3E44, 0x1C6A5A, 0xD0CCC0, 0x8A2430))
    shell = paint.plastic(rng, (width, height), color)
    body = shell.copy()
    low = 0.52 * height
    marks.panel(body, (0.04, height - low + 0.04, width - 0.08, low - 0.10), 0.006)
    marks.text(
        body, str(rng.choice(("CASH", "ATM", "BANK"))), (0.12, height - 0.35 * height), 0.10, 0xFFFFFF, bold=True
    )
    parts = standing_box((depth, width, low), shell, {"front": body[-paint.px(low) :]})
    head = height - low
    face = paint.plastic(rng, (width, head), paint.lighter(color, 0.8))
    sign = (0.04, 0.02, width - 0.08, 0.20 * head)
    marks.rectangle(face, sign, 0xF0F4F8)
    marks.text(face, "CASH 24h", (0.08, 0.15 * head), min(0.1 * head, 0.075), 0x1C3C8A, bold=True)
    screen = (0.14 * width, 0.26 * head, 0.56 * width, 0.34 * head)
    marks.rectangle(face, screen, 0x0C2C50)
    marks.frame(face, screen, 0x1A1A1C, 0.014)
    for i in range(3):
        marks.rectangle(face, (screen[0] + 0.03, screen[1] + 0.04 + 0.05 * i, rng.uniform(0.1, 0.22), 0.02), 0xC8E8FF)
        for x in (0.06 * width, 0.74 * width):
            marks.button(face, (x, screen[1] + 0.03 + 0.06 * i, 0.03, 0.025), 0xC8CCD0)
    for i in range(12):
        at = (0.2 * width + 0.055 * (i % 3), 0.66 * head + 0.045 * (i // 3), 0.04, 0.03)
        marks.button(face, at, 0xD0D4D8)
    marks.rectangle(face, (0.62 * width, 0.66 * head, 0.26 * width, 0.02), 0x30E070)
    marks.rectangle(face, (0.62 * width, 0.8 * head, 0.26 * width, 0.04), 0x0A0A0A)
    parts += standing_box((0.9 * depth, 0.97 * width, head), shell, {"front": face}, low)
    return parts


KINDS = (
    Kind("washer", "washer", WASHER, washer),
    Kind("barrel", "barrel", BARREL, barrel),
    Kind("safe", "safe", SAFE, safe),
    Kind("vending machine", "vending machine", VENDING_MACHINE, vending_machine),
    Kind("cash machine", "cash machine", CASH_MACHINE, cash_machine),
)
