# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A cash machine."""

from __future__ import annotations

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, standing_box
from edgefusion.sim.paint import Rng

CASH_MACHINE: Size = (0.60, 0.62, 1.45)


def _cash_face(rng: Rng, width: float, height: float, color: int) -> Texture:
    """A cash machine's head: sign, screen between keys, card slot, keypad, the slot for the notes."""
    face = paint.plastic(rng, (width, height), color)
    sign, ink = ((0xF0F4F8, 0x1C3C8A), (0xF0C020, 0x202020), (0x1C3C8A, 0xFFFFFF))[int(rng.integers(3))]
    marks.rectangle(face, (0.03, 0.02, width - 0.06, 0.13 * height), sign)
    words = str(rng.choice(("CASH 24h", "BANK", "ATM", "CASH POINT")))
    marks.text(face, words, (0.08, 0.12 * height), min(0.08 * height, 0.7 * width / len(words)), ink, bold=True)
    screen = (0.12 * width, 0.2 * height, 0.56 * width, 0.32 * height)
    _screen(rng, face, screen)
    right, top = screen[0] + screen[2] + 0.09, screen[1]
    marks.rectangle(face, (right - 0.02, top, width - right, 0.10), 0x2A2C30)
    marks.rectangle(face, (right, top + 0.04, width - right - 0.04, 0.012), 0x40F080)
    marks.rectangle(face, (right, top + 0.18, width - right - 0.04, 0.02), 0x101010)
    shelf = 0.6 * height
    marks.rectangle(face, (0, shelf, width, 0.28 * height), paint.lighter(color, 0.8))
    _keypad(face, (0.16 * width, shelf + 0.015), 0.25 * height)
    marks.rectangle(face, (0.64 * width, shelf + 0.04, 0.3 * width, 0.07), 0x8A8E92)
    marks.rectangle(face, (0.66 * width, shelf + 0.065, 0.26 * width, 0.022), 0x060606)
    return paint.edged(face, 0.012, 0.3)


def _screen(rng: Rng, face: Texture, rect: marks.Rect) -> None:
    """A lit screen that offers choices, four keys on either side."""
    left, top, across, down = rect
    marks.rectangle(face, (left - 0.05, top - 0.03, across + 0.10, down + 0.06), 0x24262A)
    glass = paint.shaded(paint.flat((across, down), paint.pick(rng, (0x1C5CA8, 0x2870C0, 0x186A78))), 1.2, 0.8)
    marks.text(glass, "WELCOME", (0.05 * across, 0.25 * down), 0.10 * down, 0xFFFFFF, bold=True)
    marks.inlay(face, rect, glass)
    for i in range(4):
        y = top + (i + 0.3) * down / 4
        marks.rectangle(face, (left + 0.05, y + 0.03, rng.uniform(0.08, 0.2), 0.015), 0xD8F0FF)
        for x in (left - 0.04, left + across + 0.01):
            marks.button(face, (x, y, 0.03, 0.025), 0xC8CCD0)


def _keypad(face: Texture, at: marks.At, height: float) -> None:
    """Sixteen keys on a plate, the right column coloured."""
    x, y = at
    marks.rectangle(face, (x - 0.012, y, 0.24, height), 0x505458)
    for i in range(16):
        row, column = divmod(i, 4)
        key = (0xD03028, 0xE8C020, 0x28A048, 0xD0D4D8)[row] if column == 3 else 0xD0D4D8
        at_y = y + (0.06 + 0.232 * row) * height
        marks.button(face, (x + 0.055 * column, at_y, 0.045, 0.17 * height), key)


def cash_machine(rng: Rng) -> list[Part]:
    """A free-standing machine: a head with screen and keys over the safe that holds the money."""
    depth, width, height = varied(rng, CASH_MACHINE, 0.12)
    color = paint.pick(rng, (0x24508A, 0xA8ACB0, 0x5A6068, 0x1C6A5A, 0xD0CCC0, 0x8A2430))
    shell = paint.plastic(rng, (width, height), color)
    low = rng.uniform(0.40, 0.46) * height
    body = paint.plastic(rng, (width, low), paint.lighter(color, 0.9))
    marks.panel(body, (0.04, 0.06, width - 0.08, low - 0.10), 0.006)
    marks.rings(body, (0.85 * width, 0.4 * low), [(0.014, 0x202020), (0.010, 0xB8BCC0)])
    parts = standing_box((depth, width, low), shell, {"front": body})
    head = height - low
    face = _cash_face(rng, 0.97 * width, head, paint.pick(rng, (0xC4C8CC, 0x8A9098, paint.lighter(color, 1.1))))
    return parts + standing_box((0.9 * depth, 0.97 * width, head), shell, {"front": face}, low)


KINDS = (Kind("cash machine", "cash machine", CASH_MACHINE, cash_machine),)
