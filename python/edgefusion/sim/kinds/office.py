# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Furniture and machines of an office."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import bar, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, box, placed, plain, standing_box
from edgefusion.sim.paint import Rng

BOOKCASE: Size = (0.34, 0.92, 1.75)
FILING_CABINET: Size = (0.58, 0.46, 1.25)
PHOTOCOPIER: Size = (0.62, 0.66, 1.05)
REFRIGERATOR: Size = (0.64, 0.62, 1.62)

WOODS = (0x8A5A34, 0xA8784C, 0x5E3C24, 0xC09A68, 0xD8C6A4)
SPINES = (0x8C2A24, 0x24486E, 0x2E5A3A, 0xC8A850, 0x3A3A40, 0x7A4A6A, 0xD8D0BC, 0xB86A30, 0x4A7A8A, 0xE0DCD0)


def _books(rng: Rng, face: Texture, x: float, y: float, width: float, height: float) -> None:
    """A shelf's worth of books in the rectangle, standing on its lower edge."""
    at = x
    while at < x + width - 0.02:
        if rng.random() < 0.06:  # somebody is reading one
            at += rng.uniform(0.02, 0.09)
            continue
        thick = min(float(rng.uniform(0.014, 0.05)), x + width - at)
        tall = height * float(rng.uniform(0.68, 0.94))
        color = paint.pick(rng, SPINES)
        top = y + height - tall
        marks.rectangle(face, (at, top, thick, tall), color)
        marks.rectangle(face, (at, top, thick * 0.2, tall), paint.lighter(color, 1.25))
        marks.rectangle(face, (at + thick * 0.85, top, thick * 0.15, tall), paint.lighter(color, 0.5))
        band = paint.lighter(color, 1.9 if sum(paint.bgr(color)) < 330 else 0.45)
        for share in (0.12, 0.2, 0.8) if rng.random() < 0.6 else (0.3, 0.55):
            marks.rectangle(face, (at + 0.1 * thick, top + share * tall, 0.8 * thick, 0.008), band)
        at += thick + 0.0015


def bookcase(rng: Rng) -> list[Part]:
    """Shelves full of books, closed at the back and the sides."""
    depth, width, height = varied(rng, BOOKCASE)
    color = paint.pick(rng, WOODS)
    side = paint.wood(rng, (0.5 * depth, 0.5 * height), color, True)
    face = paint.flat((width, height), color)
    back = paint.wood(rng, (0.5 * width, 0.5 * height), paint.lighter(color, 0.85), True)
    board, plinth, shelves = 0.025, 0.07, int(rng.integers(4, 6))
    pitch = (height - plinth - board) / shelves
    for stile in (0.0, width - board):
        marks.inlay(face, (stile, 0, board, height), side[:, : side.shape[1] // 4])
    for i in range(shelves):
        y = board + i * pitch
        opening = (board, y, width - 2 * board, pitch - board)
        marks.rectangle(face, opening, 0x15100C)
        _books(rng, face, *opening)
        marks.rectangle(face, (board, y, width - 2 * board, 0.02), 0x0C0906)  # the shadow of the shelf above
    parts = standing_box((0.92 * depth, width - 0.01, height - 0.01), side, {"front": face, "back": back})
    edge = paint.wood(rng, (width, board), paint.lighter(color, 1.1))
    for i in range(shelves + 1):
        z = height - board / 2 - i * pitch
        parts += box((0.94 * depth, width, board), (0.03 * depth, 0, z), edge)
    return parts + standing_box((0.97 * depth, width, plinth), edge)


def _handle(face: Texture, x: float, y: float, length: float = 0.12) -> None:
    """A bar handle with its shadow."""
    marks.rectangle(face, (x - length / 2, y + 0.006, length, 0.012), 0x303234)
    marks.rectangle(face, (x - length / 2, y, length, 0.012), 0xC4C8CA)
    marks.rectangle(face, (x - length / 2, y, length, 0.004), 0xECEEF0)


def filing_cabinet(rng: Rng) -> list[Part]:
    """Three or four deep drawers with handles and label holders."""
    depth, width, height = varied(rng, FILING_CABINET)
    color = paint.pick(rng, (0x8E9498, 0xA8A494, 0x5C6660, 0x3E4650, 0xC8C4B4, 0x6A5A4A))
    sheet = paint.painted_metal(rng, (width, height), color)
    face = sheet.copy()
    drawers = 4 if height > 1.18 else 3
    pitch = (height - 0.08) / drawers
    x = depth / 2
    parts: list[Part] = []
    for i in range(drawers):
        y = 0.03 + i * pitch
        marks.panel(face, (0.02, y, width - 0.04, pitch - 0.012), 0.006)
        marks.label(face, str(rng.choice(("A - F", "G - M", "N - S", "T - Z", "1998", "INVOICES"))),
                    (width / 2 - 0.05, y + 0.22 * pitch, 0.10, 0.045))  # fmt: skip
        marks.frame(face, (width / 2 - 0.056, y + 0.22 * pitch - 0.006, 0.112, 0.057), 0x6A6E70, 0.006)
        z = height - y - 0.62 * pitch
        _handle(face, width / 2, y + 0.62 * pitch, 0.14)
        parts += bar(0.14, 0.012, (x, 0, z), plain(0xC0C4C6), 0.025)
    marks.disc(face, (width - 0.05, 0.055), 0.011, 0xD0D2D4)
    back = sheet.copy()
    marks.panel(back, (0.015, 0.015, width - 0.03, height - 0.03), 0.003)
    marks.slots(back, (0.35 * width, 0.06, 0.3 * width, 0.05), 3)
    return standing_box((depth, width, height), sheet, {"front": face, "back": back}) + parts


def _paper_trays(rng: Rng, shell: Texture, width: float, height: float, dark: int) -> Texture:
    """The front of a copier below its output bay: a door to the toner, then drawers of paper with grips."""
    face = shell[: paint.px(height)].copy()
    trays = int(rng.integers(2, 5))
    door = rng.uniform(0.24, 0.32) * height
    marks.panel(face, (0.02, 0.015, width - 0.04, door - 0.02), 0.004)
    marks.rectangle(face, (width / 2 - 0.05, 0.02, 0.1, 0.018), dark)
    pitch = (height - door - 0.04) / trays
    for i in range(trays):
        y = door + i * pitch
        marks.panel(face, (0.02, y, width - 0.04, pitch - 0.008), 0.004)
        grip = (width / 2 - 0.08, y + 0.32 * pitch, 0.16, 0.035)
        marks.rectangle(face, grip, dark)
        marks.rectangle(face, (grip[0], grip[1] + 0.022, grip[2], 0.013), paint.lighter(dark, 1.8))
        marks.rectangle(face, (width - 0.12, y + 0.3 * pitch, 0.06, 0.045), 0xF4F4F0)
        marks.text(face, f"{i + 1}", (width - 0.1, y + 0.3 * pitch + 0.036), 0.026, 0x303438, bold=True)
    marks.rectangle(face, (0, height - 0.04, width, 0.04), dark)
    return face


def _control_panel(rng: Rng, width: float, depth: float, dark: int) -> Texture:
    """Touch screen, number keys, the green key that starts it."""
    panel = paint.plastic(rng, (width, depth), dark)
    marks.rectangle(panel, (0.05 * width, 0.15 * depth, 0.42 * width, 0.7 * depth), 0x8CC0D8)
    for i in range(3):
        marks.rectangle(panel, (0.08 * width + 0.13 * i * width, 0.3 * depth, 0.1 * width, 0.3 * depth), 0xE8F0F4)
    for i in range(12):
        at = ((0.54 + 0.07 * (i % 3)) * width, (0.12 + 0.2 * (i // 3)) * depth)
        marks.button(panel, (*at, 0.05 * width, 0.12 * depth), 0xD8D8D0)
    marks.disc(panel, (0.86 * width, 0.6 * depth), 0.2 * depth, 0x28A850)
    marks.disc(panel, (0.86 * width, 0.22 * depth), 0.1 * depth, 0xD04030)
    return panel


def _slanting(size: Size, at: Size, slope: float, texture: Texture, faces: dict[str, Texture]) -> list[Part]:
    """A plate about `at`, tipped by `slope` [rad] so that its front edge is the lower one."""
    c, s = float(np.cos(slope)), float(np.sin(slope))
    return placed(box(size, (0, 0, 0), texture, faces), at, rotation=((c, 0, s), (0, 1, 0), (-s, 0, c)))


def photocopier(rng: Rng) -> list[Part]:
    """A floor-standing copier: paper trays, the bay where copies come out, the scanner, a feeder on top."""
    depth, width, height = varied(rng, PHOTOCOPIER, 0.14)
    color = paint.pick(rng, (0xDCDAD2, 0xC8CACA, 0xE6E4DE, 0xC8C4B4), 0.03)
    dark = paint.pick(rng, (0x3A3E44, 0x4A5460, 0x2A2C30, 0x6A7078), 0.03)
    shell = paint.plastic(rng, (width, height), color)
    plain_shell, plain_dark = plain(color), plain(dark)
    low, bay, scanner = 0.53 * height, 0.17 * height, 0.12 * height
    side = shell.copy()
    marks.slots(side, (0.1 * width, 0.45 * height, 0.3 * width, 0.1 * height), 6)
    face = _paper_trays(rng, shell, width, low, dark)
    parts = standing_box((depth, width, low), side, {"front": face, "top": plain_dark})
    hollow = paint.shaded(paint.flat((width, bay), 0x2A2C30), 0.3, 1.2)
    parts += box((0.4 * depth, width, bay), (-0.3 * depth, 0, low + bay / 2), plain_shell, {"front": hollow})
    pillar = 0.14 * width
    parts += box((0.9 * depth, pillar, bay), (-0.05 * depth, (pillar - width) / 2, low + bay / 2), plain_shell)
    parts += box((0.45 * depth, 0.5 * width, 0.015), (0.2 * depth, 0.05 * width, low + 0.03), plain(0xF6F6F2))
    z = low + bay
    parts += box((0.94 * depth, width, scanner), (-0.03 * depth, 0, z + scanner / 2), shell)
    panel = _control_panel(rng, 0.9 * width, 0.17, dark)
    tipped = (0.42 * depth, 0, z + 0.75 * scanner)
    parts += _slanting((0.17, 0.9 * width, 0.035), tipped, 0.5, plain_dark, {"top": panel, "front": plain_shell})
    return parts + placed(
        _feeder(rng, 0.72 * depth, width, height - z - scanner, color), (-0.14 * depth, 0, z + scanner)
    )


def _feeder(rng: Rng, depth: float, width: float, height: float, color: int) -> list[Part]:
    """The lid over the glass with the document feeder at its left, originals lying in its tray."""
    cover, paper = plain(paint.lighter(color, 0.92)), plain(0xF8F8F4)
    parts = standing_box((depth, 0.98 * width, 0.35 * height), cover)
    housing = paint.plastic(rng, (0.36 * width, height), paint.lighter(color, 0.8))
    parts += box(
        (0.9 * depth, 0.36 * width, 0.65 * height), (0, 0.3 * width, 0.675 * height), cover, {"front": housing}
    )
    tray = ((1, 0, 0), (0, np.cos(0.2), np.sin(0.2)), (0, -np.sin(0.2), np.cos(0.2)))
    sheets = box((0.75 * depth, 0.5 * width, 0.02), (0, 0, 0), cover)
    sheets += box((0.6 * depth, 0.42 * width, 0.012), (0, 0.03, 0.016), paper)
    return parts + placed(sheets, (0, -0.12 * width, 0.7 * height), rotation=tray)


def _condenser(shell: Texture, width: float, height: float) -> Texture:
    """The back of a refrigerator: the black coil, the compressor's bay, the plate with its ratings."""
    back = shell.copy()
    left, right, top, low = 0.12 * width, 0.88 * width, 0.12 * height, 0.7 * height
    marks.slots(back, (left, top, right - left, low - top), 24, True, 0x4A4E50)
    rows = np.linspace(top, low, 15)
    for i, y in enumerate(rows.tolist()):
        marks.line(back, [(left, y), (right, y)], 0x16181A, 0.010)
        end = right if i % 2 else left
        marks.line(back, [(end, y), (end, min(low, y + float(rows[1] - rows[0])))], 0x16181A, 0.010)
    marks.rectangle(back, (0.1 * width, 0.78 * height, 0.8 * width, 0.17 * height), 0x121314)
    marks.label(back, "220V 50Hz", (0.6 * width, 0.03 * height, 0.2 * width, 0.05), 0xD8D8D0)
    return back


def refrigerator(rng: Rng) -> list[Part]:
    """A freezer door above or below a larger one, long handles, rubber gaps, magnets and notes."""
    depth, width, height = varied(rng, REFRIGERATOR, 0.14)
    color = paint.pick(rng, (0xECECE8, 0xE4E2DA, 0xC4C8CC, 0xD8D4C4, 0xB0C4C0), 0.02)
    steel = bool(rng.random() < 0.3)
    shell = paint.brushed_metal(rng, (width, height)) if steel else paint.plastic(rng, (width, height), color)
    face, foot, gap = shell.copy(), 0.06, 0.014
    split = height * (rng.uniform(0.28, 0.36) if rng.random() < 0.7 else rng.uniform(0.60, 0.68))
    marks.label(face, str(rng.choice(("FROST", "POLAR", "ARKTIS"))), (0.06, 0.06, 0.12, 0.03), 0xC8CACC, 0x303030)
    for _ in range(int(rng.integers(0, 5))):
        size = rng.uniform(0.03, 0.1)
        x, y = rng.uniform(0.1, width - 0.2), rng.uniform(0.1, height - 0.4)
        marks.shadow(face, (x, y, size, 0.8 * size))
        marks.rectangle(face, (x, y, size, 0.8 * size), paint.pick(rng, (*SPINES, 0xF4F4EC, 0xF4E890)))
    marks.rectangle(face, (0, height - foot, width, foot), 0x2A2C30)
    doors = ((0.0, split), (split + gap, height - foot))
    body, door = 0.88 * depth, 0.10 * depth
    case = {"front": plain(0x1C1E20), "back": _condenser(shell, width, height)}
    parts = placed(standing_box((body, width, height), shell, case), ((body - depth) / 2, 0, 0))
    parts += box((door, width, foot - gap), (body - depth / 2, 0, foot / 2), plain(0x2A2C30))
    grip, y_grip = plain(0x4A4E52 if steel else 0xB8BCC0), (width / 2 - 0.06) * (1 if rng.random() < 0.5 else -1)
    for low, high in doors:
        centre, tall = height - (low + high) / 2, high - low
        leaf = face[paint.px(low) : paint.px(high)].copy()
        parts += box((door, width, tall), (body + gap - depth / 2 + door / 2, 0, centre), plain(color), {"front": leaf})
        parts += _upright_bar(0.5 * tall, (body + gap + door - depth / 2, y_grip, centre), grip)
    return parts


def _upright_bar(length: float, at: Size, texture: Texture) -> list[Part]:
    """A bow handle up a front, its feet at the plane of `at`."""
    x, y, z = at
    parts = box((0.018, 0.022, length), (x + 0.03, y, z), texture)
    for end in (-1, 1):
        parts += box((0.03, 0.022, 0.03), (x + 0.015, y, z + end * 0.46 * length), texture)
    return parts


KINDS = (
    Kind("bookcase", "bookcase", BOOKCASE, bookcase),
    Kind("filing cabinet", "file", FILING_CABINET, filing_cabinet),
    Kind("photocopier", "photocopier", PHOTOCOPIER, photocopier),
    Kind("refrigerator", "refrigerator", REFRIGERATOR, refrigerator),
)
