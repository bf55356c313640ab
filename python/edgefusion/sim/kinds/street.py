# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What stands in a street."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import castors, forward, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, standing_box
from edgefusion.sim.paint import Rng

TRAFFIC_LIGHT: Size = (0.42, 0.44, 1.52)

_LAMPS = ((0xFF2A1A, 0x3A0A08), (0xFFB010, 0x3A2A08), (0x2CFFA0, 0x08301E))
"""Red, amber, green, each (lit, dark)."""


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
    parts = _cabinet(rng, depth, 0.95 * width, base_h)
    head_depth, pole_x = 0.15, -0.12
    pole = paint.painted_metal(rng, (0.25, 0.5), paint.pick(rng, (0xA8ACAE, 0x8C9094, 0x3A3C40)))
    parts += placed(drum(0.04, base_h, height - 0.1 * head_h, pole, segments=14), (pole_x, 0, 0))
    for share in (0.2, 0.75):
        parts += box((0.07, 0.11, 0.05), (pole_x + 0.02, 0, height - share * head_h), plain(0x303234))
    head = _signal_head(rng, width, head_h, head_depth)
    return parts + placed(head, (pole_x + 0.04 + head_depth, 0, height - head_h))


KINDS = (Kind("traffic light", "traffic light", TRAFFIC_LIGHT, traffic_light),)
