# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A slot machine."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, standing_box
from edgefusion.sim.paint import Rng

SLOT_MACHINE: Size = (0.56, 0.62, 1.52)
BRIGHT = (0xF0C020, 0xE03028, 0x2860D0, 0x28A858, 0xE060B0, 0xF07820)


def _fruit(strip: Texture, at: tuple[float, float], size: float, symbol: int) -> None:
    """One symbol of a reel: a seven, cherries, a bar, a bell, a melon."""
    x, y = at
    if symbol == 0:
        marks.text(strip, "7", (x - 0.4 * size, y + 0.5 * size), size, 0xD01818, True)
    elif symbol == 1:
        for side in (-1, 1):
            marks.line(strip, [(x + 0.3 * side * size, y + 0.2 * size), (x, y - 0.5 * size)], 0x207020, 0.004)
            marks.disc(strip, (x + 0.3 * side * size, y + 0.25 * size), 0.26 * size, 0xC81420)
    elif symbol == 2:
        marks.rectangle(strip, (x - 0.6 * size, y - 0.25 * size, 1.2 * size, 0.5 * size), 0x18181C)
        marks.text(strip, "BAR", (x - 0.5 * size, y + 0.15 * size), 0.36 * size, 0xF0C020, True)
    elif symbol == 3:
        bell = ((0, -0.5), (0.3, 0), (0.45, 0.35), (-0.45, 0.35), (-0.3, 0))
        marks.polygon(strip, [(x + dx * size, y + dy * size) for dx, dy in bell], 0xE8A818)
        marks.disc(strip, (x, y + 0.42 * size), 0.1 * size, 0x8A5A10)
    else:
        marks.rings(strip, at, [(0.45 * size, 0x1C7A30), (0.36 * size, 0xE8404A)])


def _reels(rng: Rng, width: float, height: float) -> Texture:
    """Three or five reels behind a window, each rounded by its shading."""
    window = paint.flat((width, height), 0x101014)
    count, rows = int(rng.choice(np.array((3, 3, 5)))), 3
    step = width / count
    for i in range(count):
        strip = paint.flat((0.9 * step, height), 0xF4F0E4)
        for row in range(rows):
            at = (0.45 * step, (row + 0.5) * height / rows)
            _fruit(strip, at, min(0.62 * step, 0.75 * height / rows), int(rng.integers(5)))
        down = np.linspace(-1, 1, strip.shape[0], dtype=np.float32)[:, None]
        marks.inlay(window, ((i + 0.05) * step, 0, 0.9 * step, height), paint.toned(strip, 1 - 0.6 * np.abs(down) ** 3))
    marks.line(window, [(0, height / 2), (width, height / 2)], 0xE02020, 0.004)
    return window


def _lit_sign(rng: Rng, width: float, height: float, color: int) -> Texture:
    """A glass sign with its words, edged with bulbs."""
    sign = paint.shaded(paint.flat((width, height), color), 1.3, 0.7)
    words = str(rng.choice(("LUCKY 7", "JACKPOT", "GOLD RUSH", "MEGA WIN", "WILD CASH")))
    tall = min(0.4 * height, 0.9 * width / len(words))
    for shift, ink in ((0.006, 0x201008), (0.0, 0xFFF4B0)):
        marks.text(sign, words, (0.09 * width + shift, 0.5 * (height + tall) + shift), tall, ink, True)
    bulbs = int(rng.integers(9, 15))
    for i in range(bulbs):
        for y in (0.02, height - 0.02):
            marks.rings(sign, ((i + 0.5) * width / bulbs, y), [(0.011, 0xB07818), (0.008, 0xFFF8D0)])
    return sign


def _slot_face(rng: Rng, width: float, height: float, color: int) -> Texture:
    """A slot machine's front, from the sign down: pay table, reels, keys, belly glass, coin tray."""
    face = paint.shaded(paint.plastic(rng, (width, height), color))
    glass, accent = paint.pick(rng, BRIGHT), paint.pick(rng, BRIGHT)
    inset, inner = 0.05, width - 0.10
    marks.inlay(face, (inset, 0.02 * height, inner, 0.14 * height), _lit_sign(rng, inner, 0.14 * height, glass))
    table = (inset, 0.18 * height, inner, 0.12 * height)
    marks.rectangle(face, table, paint.lighter(accent, 0.5))
    for i in range(3):
        y = table[1] + (i + 0.5) * table[3] / 3
        for side in (0.0, 0.5):
            x = table[0] + side * inner + 0.03
            _fruit(face, (x + 0.03, y), 0.035, int(rng.integers(5)))
            marks.text(face, str(int(rng.choice((20, 50, 100, 500)))), (x + 0.09, y + 0.012), 0.026, 0xFFF0A0, True)
    reels = (inset + 0.02, 0.33 * height, inner - 0.04, 0.2 * height)
    marks.inlay(face, reels, _reels(rng, reels[2], reels[3]))
    marks.frame(face, (reels[0] - 0.015, reels[1] - 0.015, reels[2] + 0.03, reels[3] + 0.03), 0xD8B050, 0.015)
    belly = (inset, 0.65 * height, inner, 0.19 * height)
    marks.inlay(face, belly, _lit_sign(rng, inner, belly[3], accent))
    marks.frame(face, belly, 0xC8CCD0, 0.01)
    marks.panel(face, (inset, 0.86 * height, inner, 0.11 * height), 0.008, raised=False)
    marks.rectangle(face, (inset + 0.02, 0.875 * height, inner - 0.04, 0.05 * height), 0x141414)
    return face


def _ledge(rng: Rng, width: float, depth: float) -> list[Part]:
    """The console with the keys, its back at x = 0, its middle at z = 0."""
    keys, count = paint.brushed_metal(rng, (width, 0.06)), int(rng.integers(5, 8))
    for i in range(count):
        marks.button(keys, (width * (i + 0.2) / count, 0.015, 0.6 * width / count, 0.03), paint.pick(rng, BRIGHT))
    return box((depth, width, 0.06), (depth / 2, 0, 0), plain(0x8A8E92), {"top": keys, "front": keys})


def slot_machine(rng: Rng) -> list[Part]:
    """A one-armed bandit: lit signs, reels, a console with keys, a lamp on top, often the arm."""
    depth, width, height = varied(rng, SLOT_MACHINE, 0.14)
    color = paint.pick(rng, (0x8A1820, 0x201C24, 0x1C2C5A, 0x4A2A18, 0x5A2468, 0x9A9EA4))
    shell = paint.plastic(rng, (width, 0.6), color)
    candle, arm, ledge = 0.09, 0.07, 0.07
    body_w, body_d, tall = width - arm, depth - ledge, height - candle
    face = _slot_face(rng, body_w, tall, color)
    parts = standing_box((body_d, body_w, tall), shell, {"front": face})
    parts += placed(_ledge(rng, body_w, ledge), (body_d / 2, 0, 0.405 * tall))
    for low, high, lit in ((0.0, 0.45, 0xE03028), (0.45, 0.9, 0xFFF0C0), (0.9, 1.0, 0xC0C4C8)):
        parts += drum(0.045, tall + low * candle, tall + high * candle, plain(lit), segments=14)
    side, z = body_w / 2, 0.5 * tall
    steel = plain(0xC8CCD0)
    parts += box((0.07, 0.4 * arm, 0.10), (0.1, side + 0.2 * arm, z), steel)
    lever = drum(0.011, 0, 0.3, steel, segments=10)
    ball = [(0.035 * float(np.cos(t)), 0.32 + 0.035 * float(np.sin(t))) for t in np.linspace(-np.pi / 2, np.pi / 2, 8)]
    lever.append(lathe(ball, plain(paint.pick(rng, (0xC81820, 0x18181A, 0xE8B820))), 16))
    return parts + placed(lever, (0.1, side + arm - 0.035, z))


KINDS = (Kind("slot machine", "slot", SLOT_MACHINE, slot_machine),)
