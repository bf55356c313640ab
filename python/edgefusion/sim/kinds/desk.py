# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A desk with what lies and stands on it."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import knob, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.kinds.office import SPINES, WOODS
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, standing_box
from edgefusion.sim.paint import Rng

DESK: Size = (0.70, 1.40, 1.16)


def _drawers(rng: Rng, panel: Texture, width: float, height: float) -> tuple[Texture, list[Part]]:
    """The front of a desk's pedestal, its handles before the plane x = 0, z from its lower edge."""
    face = panel.copy()
    count = int(rng.integers(2, 4))
    shares = (0.22, 0.26, 0.52) if count == 3 else (0.28, 0.72)
    handles: list[Part] = []
    y = 0.02
    metal = int(rng.choice(np.asarray((0x9A9EA0, 0xA08040, 0x303234, 0x4A3020))))
    for share in shares:
        high = share * (height - 0.04)
        marks.panel(face, (0.02, y, width - 0.04, high - 0.012), 0.004)
        marks.shadow(face, (width / 2 - 0.02, y + 0.45 * high - 0.015, 0.04, 0.03))
        handles += knob(0.016, 0.022, metal, (0, 0, height - y - 0.45 * high), 10)
        y += high
    return face, handles


def desk(rng: Rng) -> list[Part]:
    """A writing desk: drawers beside a kneehole with a modesty panel; a screen, a lamp, books and papers on it."""
    depth, width, height = varied(rng, DESK, 0.14)
    color, leaf, top = paint.pick(rng, WOODS), 0.035, rng.uniform(0.62, 0.66) * height
    panel = paint.wood(rng, (0.5, top), color)
    recess, low = 0.05, top - leaf  # deeper, and a laser would see two pedestals and a wall
    columns = [rng.uniform(0.26, 0.32) * width, 0.05 if rng.random() < 0.7 else 0.26 * width]
    if rng.random() < 0.5:
        columns.reverse()
    knee = paint.toned(panel, np.linspace(0.2, 0.5, panel.shape[0], dtype=np.float32)[:, None])
    body = 0.94 * depth
    parts = box((body - recess, 0.95 * width, low), (-recess / 2, 0, low / 2), panel, {"front": knee})
    for side, column in zip((-1, 1), columns):
        y = side * (0.97 * width - column) / 2
        face, handles = _drawers(rng, panel, column, low) if column > 0.1 else (panel, [])
        parts += box((body, column, low), (0, y, low / 2), panel, {"front": face}) + placed(handles, (body / 2, y, 0))
    gap, middle = 0.97 * width - sum(columns), (columns[0] - columns[1]) / 2
    parts += box((0.03, gap, 0.09), (body / 2 - 0.04, middle, low - 0.045), panel)
    surface = paint.wood(rng, (0.5 * width, 0.5 * depth), paint.lighter(color, 1.12))
    parts += box((depth, width, leaf), (0, 0, low + leaf / 2), plain(paint.lighter(color, 0.9)), {"top": surface})
    return parts + placed(_on_the_desk(rng, depth, width, height - top), (0, 0, top))


def _on_the_desk(rng: Rng, depth: float, width: float, tallest: float) -> list[Part]:
    """A screen, a lamp beside it, a row of books, papers; z from the desk's top."""
    side = 1 if rng.random() < 0.5 else -1
    parts = placed(_screen(rng, 0.86 * tallest), (-0.1 * depth, -side * 0.05 * width, 0), yaw=rng.uniform(-0.2, 0.2))
    parts += placed(_lamp(rng, tallest), (-0.15 * depth, side * 0.36 * width, 0))
    y = -side * 0.46 * width
    for _ in range(int(rng.integers(3, 7))):
        w, h = rng.uniform(0.02, 0.05), rng.uniform(0.17, 0.26)
        parts += box((0.17, w, h), (-0.1 * depth, y + side * w / 2, h / 2), plain(paint.pick(rng, SPINES)))
        y += side * (w + 0.002)
    for _ in range(int(rng.integers(1, 3))):
        w, d, h = rng.uniform(0.2, 0.3), rng.uniform(0.15, 0.22), rng.uniform(0.005, 0.05)
        at = (rng.uniform(0.1, 0.3) * depth, rng.uniform(-0.35, 0.35) * width, h / 2)
        parts += box((d, w, h), at, plain(paint.pick(rng, (0xF0EEE6, 0xE4E0D4, 0x6A4A34))))
    return parts


def _screen(rng: Rng, height: float) -> list[Part]:
    """A flat monitor on a foot."""
    width = 1.25 * height
    shell = plain(paint.pick(rng, (0x1C1C1E, 0x303234, 0xC8C8C4)))
    picture = paint.shaded(paint.flat((width, 0.8 * height), paint.pick(rng, (0x3A6EA5, 0x2A4A6A, 0x14181C))), 1.2, 0.8)
    marks.frame(picture, (0, 0, width, 0.8 * height), 0x18181A, 0.02)
    for i in range(int(rng.integers(0, 9))):
        marks.line(
            picture, [(0.05, 0.05 + 0.025 * i), (rng.uniform(0.1, 0.8) * width, 0.05 + 0.025 * i)], 0xE8ECEE, 0.008
        )
    parts = box((0.045, width, 0.8 * height), (0, 0, 0.6 * height), shell, {"front": picture})
    parts += box((0.03, 0.06, 0.3 * height), (-0.03, 0, 0.16 * height), shell)
    return parts + standing_box((0.18, 0.24, 0.02), shell)


def _lamp(rng: Rng, height: float) -> list[Part]:
    """A desk lamp: a foot, two arms, a shade."""
    paintwork = plain(paint.pick(rng, (0x1E2022, 0xB02820, 0x2A4A8A, 0xD8D8D2, 0x2E6A3A)))
    parts = drum(0.08, 0, 0.025, paintwork, segments=16)
    parts += box((0.015, 0.015, height), (-0.04, 0, height / 2), plain(0xA8ACAE))
    parts += box((0.2, 0.015, 0.015), (0.05, 0, height - 0.01), plain(0xA8ACAE))
    shade = [(0.0, 0.0), (0.02, 0.0), (0.095, -0.12)]
    inner = [(0.09, -0.12), (0.02, -0.02)]
    head = [lathe(shade[::-1], paintwork, 16), lathe(inner[::-1], plain(0xFFF4D0), 16)]
    return parts + placed(head, (0.13, 0, height))


KINDS = (Kind("desk", "desk", DESK, desk),)
