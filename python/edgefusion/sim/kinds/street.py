# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What stands in a street."""

from __future__ import annotations

from typing import Tuple

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import bar, castors, forward, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, prism, scaled, standing_box
from edgefusion.sim.paint import Rng

TRAFFIC_LIGHT: Size = (0.42, 0.44, 1.52)
ASHCAN: Size = (0.46, 0.46, 0.92)
MAILBOX: Size = (0.52, 0.50, 1.28)
PARKING_METER: Size = (0.20, 0.21, 1.16)

_LAMPS = ((0xFF2A1A, 0x3A0A08), (0xFFB010, 0x3A2A08), (0x2CFFA0, 0x08301E))
"""Red, amber, green, each (lit, dark)."""

_Row = Tuple[float, float, float]
Rotation = Tuple[_Row, _Row, _Row]


def _lens(rng: Rng, color: int, dark: int, lit: bool) -> Texture:
    """What runs around a lamp's dome: its upper edge is the dome's middle."""
    glass = paint.flat((0.3, 0.12), color if lit else dark)
    rows = np.linspace(0, 1, glass.shape[0], dtype=np.float32)[:, None, None]
    if lit:
        glow = np.exp(-((rows / 0.55) ** 2))
        return np.asarray(glass + (255 - glass) * 0.85 * glow, np.uint8)
    facets = paint.clouds(rng, (glass.shape[0], glass.shape[1]), 4)
    return paint.toned(glass, 1.3 + 0.2 * facets)


def _visor(radius: float, length: float, texture: Texture) -> list[Part]:
    """A hood around a lamp, its foot in the plane x = 0, cut off aslant: long above, short below."""
    profile = [(radius, 0), (radius, length), (0.95 * radius, length), (0.95 * radius, 0)]
    tube = forward([lathe(profile, texture, 20)], (0, 0, 0))
    slant = ((1, 0, 0.32 * length / radius), (0, 1, 0), (0, 0, 1))
    points = tube[0].vertices
    rim = points[:, 0] > 0.5 * length
    moved = np.where(rim[:, None], points @ np.asarray(slant).T, points)
    return [Part(moved.astype(np.float32), tube[0].normals, tube[0].uv, tube[0].triangles, texture)]


def _signal_head(rng: Rng, width: float, height: float, depth: float) -> list[Part]:
    """Three lamps, one of them lit, before a housing whose front is the plane x = 0; z from its lower edge."""
    color = paint.pick(rng, (0xE8B010, 0xE0A818, 0x1C1E1E, 0x1E2C26, 0x26282A), 0.03)
    board = paint.plastic(rng, (width, height), paint.pick(rng, (0x161818, 0x1C1E20)))
    marks.panel(board, (0, 0, width, height), 0.014, raised=False)
    if rng.random() < 0.4:
        marks.frame(board, (0.008, 0.008, width - 0.016, height - 0.016), 0xE8E8E4, 0.02)
    body_w = rng.uniform(0.72, 0.8) * width
    face = paint.plastic(rng, (body_w, 0.94 * height), color)
    pitch = 0.94 * height / 3
    radius = min(0.4 * body_w, 0.40 * pitch)
    for gap in (1, 2):
        marks.line(face, [(0, gap * pitch), (body_w, gap * pitch)], paint.lighter(color, 0.4), 0.005)
    hood = plain(paint.lighter(color, 0.55) if sum(paint.bgr(color)) > 200 else 0x141616)
    lit = int(rng.choice(3, p=(0.45, 0.15, 0.4)))
    parts = box((0.012, width, height), (-0.5 * depth, 0, height / 2), board)
    parts += box((depth, body_w, 0.94 * height), (-0.5 * depth, 0, height / 2), plain(color), {"front": face})
    for i, (bright, dark) in enumerate(_LAMPS):
        z = height * 0.97 - (i + 0.5) * pitch
        marks.rings(face, (body_w / 2, (i + 0.5) * pitch), [(1.12 * radius, paint.lighter(color, 0.45))])
        dome = lathe([(radius, 0), (0.75 * radius, 0.018), (0, 0.028)], _lens(rng, bright, dark, i == lit), 24)
        parts += forward([dome], (0.002, 0, z))
        parts += placed(_visor(radius * 1.06, rng.uniform(0.11, 0.14), hood), (0, 0, z))
    return parts


def _cabinet(rng: Rng, depth: float, width: float, height: float) -> list[Part]:
    """Where a portable light keeps its battery and its controller: a ballast on castors with a door."""
    color = paint.pick(rng, (0xD8801C, 0xE0B020, 0x8C9094, 0xC8C8C0, 0x4A5058))
    wheel = 0.045
    sheet = paint.painted_metal(rng, (width, height - wheel), color)
    side = sheet.copy()
    marks.slots(side, (0.3 * width, 0.08, 0.4 * width, 0.12), 5)
    door = sheet.copy()
    marks.panel(door, (0.02, 0.03, width - 0.04, height - wheel - 0.05), 0.005)
    marks.rectangle(door, (width - 0.07, 0.2, 0.02, 0.06), 0x202224)
    marks.label(door, str(rng.choice(("LSA 2", "UNIT 4", "SIGNAL B", "TS-12"))), (0.07, 0.07, 0.15, 0.05))
    if rng.random() < 0.5:
        strip = (0.02, height - wheel - 0.11, width - 0.04, 0.07)
        marks.rectangle(door, strip, 0xE8E8E0)
        marks.hatched(door, strip, 0xC02820, 0.05)
    parts = castors(0.95 * depth, width, wheel)
    parts += standing_box((depth, width, height - wheel), side, {"front": door, "top": sheet}, wheel)
    return parts


def traffic_light(rng: Rng) -> list[Part]:
    """A portable traffic light: a signal head on a pole in a wide ballast with a cabinet."""
    depth, width, height = varied(rng, TRAFFIC_LIGHT)
    head_h = rng.uniform(0.54, 0.6) * height
    base_h = rng.uniform(0.44, 0.5)
    parts = _cabinet(rng, depth, width, base_h)
    head_depth, pole_x = 0.15, -0.17
    pole = paint.painted_metal(rng, (0.25, 0.5), paint.pick(rng, (0xA8ACAE, 0x8C9094, 0x3A3C40)))
    parts += placed(drum(0.04, base_h, height - 0.1 * head_h, pole, segments=14), (pole_x, 0, 0))
    for share in (0.2, 0.75):
        parts += box((0.07, 0.11, 0.05), (pole_x + 0.02, 0, height - share * head_h), plain(0x303234))
    head = _signal_head(rng, width, head_h, head_depth)
    return parts + placed(head, (pole_x + 0.04 + head_depth, 0, height - head_h))


def _bin_side(rng: Rng, radius: float, height: float, color: int) -> Texture:
    """What runs around a litter bin: upright slats, ribs or holes between two bands."""
    around = 2 * np.pi * radius
    wrap = paint.painted_metal(rng, (around, height), color)
    pattern = int(rng.integers(3))
    low, high, count = 0.1 * height, 0.8 * height, int(rng.integers(22, 34))
    for i in range(count):
        x = around * i / count
        if pattern == 0:
            marks.rectangle(wrap, (x, low, 0.35 * around / count, high), paint.lighter(color, 0.25))
        elif pattern == 1:
            marks.rectangle(wrap, (x, low, 0.3 * around / count, high), paint.lighter(color, 0.65))
            marks.rectangle(
                wrap, (x + 0.3 * around / count, low, 0.15 * around / count, high), paint.lighter(color, 1.3)
            )
        else:
            for row in range(14):
                at = (x + (0.25 + 0.5 * (row % 2)) * around / count, low + (row + 0.5) * high / 14)
                marks.disc(wrap, at, 0.014, paint.lighter(color, 0.2))
    if rng.random() < 0.6:
        plate = (around / 2 - 0.13, 0.3 * height, 0.26, 0.09)
        marks.label(wrap, str(rng.choice(("LITTER", "TRASH", "WASTE"))), plate, 0xE8E8E0, paint.lighter(color, 0.7))
    return wrap


def ashcan(rng: Rng) -> list[Part]:
    """A round litter bin, open above its rim or under a dome with a flap."""
    depth, width, height = varied(rng, ASHCAN)
    radius = 0.5
    color = paint.pick(rng, (0x2E5A38, 0x3A4048, 0x24343C, 0x8A9094, 0x4A3A30, 0x30507A))
    domed = bool(rng.random() < 0.5)
    body = rng.uniform(0.72, 0.78) * height if domed else height
    wrap = _bin_side(rng, 0.5 * width, body, color)
    band, dark = plain(paint.lighter(color, 0.8)), plain(0x0E0F10)
    taper = rng.uniform(0.84, 0.95) * radius
    parts = [
        lathe([(0, 0), (taper, 0), (taper * 1.01, 0.05)], band, 28),
        lathe([(taper, 0.05), (0.97 * radius, body - 0.05)], wrap, 28),
        lathe([(0.97 * radius, body - 0.06), (radius, body - 0.045), (radius, body), (0.9 * radius, body)], band, 28),
    ]
    if domed:
        parts += _dome(rng, radius, body, height, color)
    else:
        parts.append(lathe([(0.9 * radius, body), (0.86 * radius, body - 0.12), (0, body - 0.12)], dark, 28))
    seam_behind = placed(parts, yaw=np.pi)
    return scaled(seam_behind, (depth, width, 1))


def _dome(rng: Rng, radius: float, z0: float, z1: float, color: int) -> list[Part]:
    """A lid with four mouths, each under a flap that says what to put in."""
    lid = paint.painted_metal(rng, (1.4, z1 - z0), paint.lighter(color, rng.uniform(0.85, 1.15)))
    for i in range(4):
        x = (i + 0.5) * 0.35 - 0.11
        marks.rectangle(lid, (x, 0.5 * (z1 - z0), 0.22, 0.36 * (z1 - z0)), 0x0C0D0E)
        marks.frame(lid, (x, 0.5 * (z1 - z0), 0.22, 0.36 * (z1 - z0)), paint.lighter(color, 1.5), 0.008)
    turns = np.linspace(0, np.pi / 2, 7)
    arc = [(0.97 * radius * float(np.cos(t)), z0 + 0.4 * (z1 - z0) + 0.6 * (z1 - z0) * float(np.sin(t))) for t in turns]
    return [lathe([(0.97 * radius, z0), *arc], lid, 28)]


ALONG_X = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
ALONG_Y = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
"""What turns an upright prism so that it lies along an axis, its outline's second coordinate upwards."""


def _arched(width: float, height: float, axis: Rotation, length: float, skin: Texture, face: Texture) -> list[Part]:
    """A body `length` long, under a half-circle between upright sides; `face`: what closes it at both ends."""
    turns = np.linspace(0, np.pi, 15)
    straight = height - width / 2
    arc = [(width / 2 * float(np.cos(t)), straight + width / 2 * float(np.sin(t))) for t in turns]
    outline = [(-width / 2, 0.0), (width / 2, 0.0), *arc]
    return placed(prism(outline, -length / 2, length / 2, skin, np.ascontiguousarray(face[::-1])), rotation=axis)


def _letter_front(rng: Rng, width: float, height: float, color: int) -> Texture:
    """Below the mouth of a letter box: its sign, the notice with the hours, the door for the collection."""
    ink = 0xF4F4F0 if sum(paint.bgr(color)) < 420 else 0x202430
    face = paint.painted_metal(rng, (width, height), color)
    marks.text(face, str(rng.choice(("MAIL", "POST", "LETTERS"))), (0.1 * width, 0.2 * height), 0.065, ink, bold=True)
    marks.rectangle(face, (0.1 * width, 0.23 * height, 0.8 * width, 0.012), ink)
    notice = (0.3 * width, 0.29 * height, 0.4 * width, 0.2 * height)
    marks.rectangle(face, notice, 0xF4F4EE)
    for i in range(6):
        x, y = notice[0] + 0.015, notice[1] + (i + 1) * notice[3] / 7
        marks.line(face, [(x, y), (x + rng.uniform(0.5, 1) * (notice[2] - 0.03), y)], 0x404858, 0.005)
    door = (0.08 * width, 0.54 * height, 0.84 * width, 0.42 * height)
    marks.panel(face, door, 0.006)
    marks.rings(face, (0.82 * width, 0.66 * height), [(0.018, 0x202020), (0.013, 0xC8CCD0), (0.004, 0x101010)])
    return face


def mailbox(rng: Rng) -> list[Part]:
    """A street letter box with a round top, a flap to pull down, a sign and a notice."""
    depth, width, height = varied(rng, MAILBOX)
    color = paint.pick(rng, (0x1C3C8C, 0x24489C, 0x1C3C8C, 0xB81C20, 0xE0B010), 0.03)
    foot, shell = 0.07, plain(color)
    side = paint.painted_metal(rng, (depth, height - foot), color)
    marks.frame(side, (0.06 * depth, 0.3 * height, 0.88 * depth, 0.55 * height), paint.lighter(color, 0.7), 0.008)
    parts = _arched(0.94 * depth, height - foot, ALONG_Y, width, shell, side)
    parts = placed(parts, (0, 0, foot))
    straight = height - foot - 0.47 * depth
    front = _letter_front(rng, width, straight, color)
    parts += box((0.012, 0.98 * width, straight), (0.47 * depth, 0, foot + straight / 2), shell, {"front": front})
    plate = paint.painted_metal(rng, (0.98 * width, straight), color)
    marks.panel(plate, (0.05, 0.08, 0.98 * width - 0.1, straight - 0.14), 0.003)
    parts += box((0.006, 0.98 * width, straight), (-0.47 * depth, 0, foot + straight / 2), shell, {"back": plate})
    flap = paint.painted_metal(rng, (0.86 * width, 0.2), paint.lighter(color, 1.1))
    marks.panel(flap, (0, 0, 0.86 * width, 0.2), 0.008)
    z = foot + straight + 0.04
    parts += box((0.07, 0.86 * width, 0.2), (0.46 * depth - 0.02, 0, z), shell, {"front": flap})
    parts += bar(0.4 * width, 0.018, (0.46 * depth + 0.015, 0, z + 0.05), plain(paint.lighter(color, 0.6)), 0.03)
    return parts + standing_box((0.9 * depth, 0.94 * width, foot), plain(0x24262A))


def _meter_face(rng: Rng, width: float, height: float, color: int) -> Texture:
    """A parking meter's front: a dial behind glass in the round top, a coin slot, a plate, a door."""
    face = paint.painted_metal(rng, (width, height), color)
    middle, radius = width / 2, 0.40 * width
    dial = (middle, width / 2)
    marks.rings(face, dial, [(radius * 1.12, 0x1A1C1E), (radius, 0xE8ECE4)])
    marks.rectangle(face, (middle - radius, dial[1] + 0.2 * radius, 2 * radius, 0.4 * radius), 0x3A4248)
    for turn in np.linspace(np.pi, 2 * np.pi, 7):
        c, s = float(np.cos(turn)), float(np.sin(turn))
        marks.line(face, [(middle + r * radius * c, dial[1] + r * radius * s) for r in (0.7, 0.9)], 0x202428, 0.004)
    turn = rng.uniform(np.pi, 2 * np.pi)
    tip = (middle + 0.75 * radius * float(np.cos(turn)), dial[1] + 0.75 * radius * float(np.sin(turn)))
    marks.line(face, [dial, tip], 0xC02820, 0.006)
    low = width
    marks.rectangle(face, (0.2 * width, low + 0.03 * height, 0.6 * width, 0.1 * height), 0xF0E8C0)
    marks.text(face, str(rng.choice(("2 HOUR", "1 HOUR", "PAY"))), (0.24 * width, low + 0.11 * height), 0.022, 0x202428)
    marks.rings(face, (middle, low + 0.24 * height), [(0.16 * width, 0x707478), (0.13 * width, 0xC8CCD0)])
    marks.rectangle(face, (middle - 0.004, low + 0.2 * height, 0.008, 0.08 * height), 0x101214)
    marks.panel(face, (0.1 * width, low + 0.36 * height, 0.8 * width, 0.5 * (height - low)), 0.004)
    return face


def parking_meter(rng: Rng) -> list[Part]:
    """A parking meter: a round-topped head on a thin pole."""
    depth, width, height = varied(rng, PARKING_METER)
    color = paint.pick(rng, (0x6A7278, 0x8C9498, 0x3A444C, 0x9C9080, 0x4A5A50), 0.04)
    head, radius = rng.uniform(0.42, 0.48), rng.uniform(0.026, 0.034)
    pole = paint.painted_metal(rng, (0.2, height), paint.pick(rng, (0x7A8084, 0x9CA0A2, 0x50565A)))
    parts = drum(radius, 0.02, height - head, pole, segments=12)
    parts += drum(0.5 * width, 0, 0.02, plain(0x5A5E62), segments=16)
    parts += placed(drum(1.5 * radius, 0, 0.05, pole, segments=12), (0, 0, height - head - 0.05))
    face = _meter_face(rng, width, head, color)
    return parts + placed(_arched(width, head, ALONG_X, 0.7 * depth, plain(color), face), (0, 0, height - head))


KINDS = (
    Kind("traffic light", "traffic light", TRAFFIC_LIGHT, traffic_light),
    Kind("ashcan", "ashcan", ASHCAN, ashcan),
    Kind("mailbox", "mailbox", MAILBOX, mailbox),
    Kind("parking meter", "parking meter", PARKING_METER, parking_meter),
)
