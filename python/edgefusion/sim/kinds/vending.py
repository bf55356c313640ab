# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A vending machine: what it sells stands behind glass."""

from __future__ import annotations

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.marks import Rect
from edgefusion.sim.mesh import Part, Texture, box, plain, standing_box
from edgefusion.sim.paint import Rng

VENDING_MACHINE: Size = (0.78, 0.90, 1.72)

_GOODS = (0xC82828, 0x2848C8, 0xE8C020, 0x28A048, 0xE87820, 0xF0F0F0, 0x7A3CA0, 0x5A3020, 0x30A8C8)


def _bottle(face: Texture, rect: Rect, color: int) -> None:
    """A bottle with neck, cap and label."""
    x, y, w, h = rect
    marks.rectangle(face, (x + 0.36 * w, y, 0.28 * w, 0.1 * h), 0xE8E8E8)
    shoulder = [
        (x + 0.38 * w, y + 0.1 * h),
        (x + 0.62 * w, y + 0.1 * h),
        (x + 0.9 * w, y + 0.36 * h),
        (x + 0.1 * w, y + 0.36 * h),
    ]
    marks.polygon(face, shoulder, paint.lighter(color, 0.7))
    marks.rectangle(face, (x + 0.1 * w, y + 0.36 * h, 0.8 * w, 0.64 * h), paint.lighter(color, 0.7))
    marks.rectangle(face, (x + 0.1 * w, y + 0.46 * h, 0.8 * w, 0.32 * h), paint.lighter(color, 1.4))
    marks.rectangle(face, (x + 0.18 * w, y + 0.36 * h, 0.12 * w, 0.64 * h), paint.lighter(color, 1.7))


def _can(face: Texture, rect: Rect, color: int) -> None:
    """A can with a bright rim and a band."""
    x, y, w, h = rect
    marks.rectangle(face, (x + 0.1 * w, y + 0.3 * h, 0.8 * w, 0.7 * h), 0xC8CCD0)
    marks.rectangle(face, (x + 0.08 * w, y + 0.35 * h, 0.84 * w, 0.6 * h), color)
    marks.rectangle(face, (x + 0.08 * w, y + 0.55 * h, 0.84 * w, 0.14 * h), 0xF0F0EC)
    marks.rectangle(face, (x + 0.2 * w, y + 0.35 * h, 0.14 * w, 0.6 * h), paint.lighter(color, 1.6))


def _bag(face: Texture, rect: Rect, color: int) -> None:
    """A bag of crisps: pinched seams, a round emblem."""
    x, y, w, h = rect
    marks.rectangle(face, (x + 0.04 * w, y + 0.2 * h, 0.92 * w, 0.8 * h), color)
    for seam in (0.2, 0.94):
        marks.rectangle(face, (x + 0.04 * w, y + seam * h, 0.92 * w, 0.06 * h), paint.lighter(color, 0.6))
    marks.disc(face, (x + 0.5 * w, y + 0.58 * h), 0.26 * w, paint.lighter(color, 1.8))
    marks.rectangle(face, (x + 0.2 * w, y + 0.54 * h, 0.6 * w, 0.1 * h), 0xF4F0E0)


def _shelves(rng: Rng, face: Texture, glass: Rect) -> None:
    """A lit interior, a kind of goods in every row, prices along the shelves, the street mirrored in the glass."""
    x0, y0, width, height = glass
    light = rng.uniform(0.25, 0.9)
    marks.rectangle(face, glass, paint.lighter(0xC8D0D4, light))
    rows = int(rng.integers(4, 7))
    tall = height / rows
    for row in range(rows):
        columns = int(rng.integers(5, 9))
        wide, y = width / columns, y0 + row * tall
        draw = (_bottle, _can, _bag)[int(rng.integers(3))]
        marks.rectangle(face, (x0, y, width, 0.12 * tall), paint.lighter(0xA0A8AC, 0.4 * light))
        color = paint.pick(rng, _GOODS)
        for column in range(columns):
            if rng.random() < 0.6:
                color = paint.pick(rng, _GOODS)
            if rng.random() < 0.93:  # else sold out
                draw(face, (x0 + column * wide + 0.08 * wide, y + 0.12 * tall, 0.84 * wide, 0.72 * tall), color)
            tag = (x0 + (column + 0.3) * wide, y + 0.88 * tall, 0.4 * wide, 0.08 * tall)
            marks.rectangle(face, (x0 + column * wide, y + 0.84 * tall, wide, 0.16 * tall), 0x3A3E42)
            marks.rectangle(face, tag, 0xF4F4E8)
    rim = paint.px(x0), paint.px(x0 + width)
    band = face[paint.px(y0) : paint.px(y0 + height), rim[0] : rim[1]]
    start = int(rng.uniform(0.1, 0.6) * band.shape[1])
    stripe = band[:, start : start + band.shape[1] // 5]
    stripe[:] = paint.toned(stripe, 1.12)
    marks.frame(face, (x0 - 0.015, y0 - 0.015, width + 0.03, height + 0.03), 0x202224, 0.015)


def _coin_column(face: Texture, rect: Rect) -> None:
    """Display, keys, slots for coins and notes, the returned coins."""
    x, y, w, h = rect
    marks.rectangle(face, rect, 0x2A2C30)
    marks.rectangle(face, (x + 0.12 * w, y + 0.06 * h, 0.76 * w, 0.06 * h), 0x50D890)
    for i in range(12):
        at = (x + (0.14 + 0.26 * (i % 3)) * w, y + (0.18 + 0.055 * (i // 3)) * h)
        marks.button(face, (*at, 0.2 * w, 0.038 * h), 0xC8CACC)
    marks.rectangle(face, (x + 0.15 * w, y + 0.46 * h, 0.7 * w, 0.09 * h), 0x9CA0A4)
    marks.rectangle(face, (x + 0.25 * w, y + 0.5 * h, 0.5 * w, 0.012), 0x101214)
    marks.rectangle(face, (x + 0.45 * w, y + 0.62 * h, 0.012, 0.05 * h), 0xD8DADC)
    marks.rectangle(face, (x + 0.2 * w, y + 0.8 * h, 0.6 * w, 0.1 * h), 0x0C0D0E)


def _sign(rng: Rng, size: paint.Extent, color: int) -> Texture:
    """The lit banner above the glass."""
    bright = sum(paint.bgr(color)) > 420
    banner = paint.shaded(paint.flat(size, color if bright else paint.lighter(color, 1.4)), 1.25, 0.9)
    words = str(rng.choice(("COLD DRINKS", "SNACKS", "FRESH", "DRINKS & SNACKS", "SODA", "REFRESH")))
    height = min(0.5 * size[1], 1.1 * size[0] / len(words))
    marks.text(
        banner, words, (0.06 * size[0], 0.5 * (size[1] + height)), height, 0xB01C20 if bright else 0xFFFFFF, True
    )
    return banner


def vending_machine(rng: Rng) -> list[Part]:
    """Rows of bottles, cans and bags behind glass, a column with keys and slots, a flap below."""
    depth, width, height = varied(rng, VENDING_MACHINE, 0.12)
    color = paint.pick(rng, (0xB01C20, 0xC02428, 0x1C3C8A, 0x202226, 0x1C7A4A, 0xD8D8D8, 0x2A6AB0))
    shell = paint.plastic(rng, (width, height), color)
    face = shell.copy()
    column = 0.2 * width
    glass = (0.06 * width, 0.15 * height, 0.7 * width, rng.uniform(0.6, 0.64) * height)
    _shelves(rng, face, glass)
    _coin_column(face, (width - column, glass[1], 0.84 * column, 0.75 * glass[3]))
    marks.inlay(face, (0.03 * width, 0.015 * height, 0.94 * width, 0.11 * height),
                _sign(rng, (0.94 * width, 0.11 * height), color))  # fmt: skip
    flap = (0.12 * width, 0.84 * height, 0.58 * width, 0.1 * height)
    marks.rectangle(face, flap, 0x141618)
    marks.panel(face, flap, 0.008, raised=False)
    marks.text(face, "PUSH", (0.34 * width, 0.9 * height), 0.03, 0xD0D4D8)
    back = shell.copy()
    marks.slots(back, (0.1 * width, 0.7 * height, 0.8 * width, 0.2 * height), 9)
    door = 0.09
    case = {"front": plain(0x18191A), "back": back}
    parts = box((depth - door, width, height - 0.04), (-door / 2, 0, 0.02 + height / 2), shell, case)
    parts += box((door - 0.006, width, height - 0.06), ((depth - door) / 2 + 0.003, 0, 0.03 + height / 2), shell,
                 {"front": paint.edged(face, 0.01, 0.3)})  # fmt: skip
    return parts + standing_box((0.94 * depth, 0.96 * width, 0.04), plain(0x141516))


KINDS = (Kind("vending machine", "vending machine", VENDING_MACHINE, vending_machine),)
