# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Instruments and devices of a laboratory."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import castors, forward, knob, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, lathe, placed, plain, standing_box
from edgefusion.sim.paint import Rng

OSCILLOSCOPE: Size = (0.46, 0.50, 0.66)
LOUDSPEAKER: Size = (0.34, 0.30, 0.98)
Samples = npt.NDArray[np.float64]


def _trace(rng: Rng, t: Samples) -> Samples:
    """One wave in -1..1 over t in 0..1."""
    phase = 2 * np.pi * (rng.uniform(1.5, 5) * t + rng.uniform())
    wave = np.sin(phase)
    shapes = (wave, np.sign(wave), 2 / np.pi * np.arcsin(wave), wave * np.exp(-2 * t), wave * np.sin(np.pi * t))
    return np.asarray(shapes[int(rng.integers(len(shapes)))])


def _scope_screen(rng: Rng, width: float, height: float) -> Texture:
    """Tube with graticule and one or two traces."""
    glass, glow = ((0x0C3B34, 0x7CFFC0), (0x16324A, 0x8FE8FF), (0x0A2A14, 0x86FF6A))[int(rng.integers(3))]
    face = paint.edged(paint.flat((width, height), glass), 0.05, 0.45)
    for i in range(11):
        marks.line(face, [(width * i / 10, 0), (width * i / 10, height)], paint.lighter(glass, 1.9), 0.002)
    for i in range(9):
        marks.line(face, [(0, height * i / 8), (width, height * i / 8)], paint.lighter(glass, 1.9), 0.002)
    t = np.linspace(0.02, 0.98, 120)
    for level in (0.3, 0.7) if rng.random() < 0.5 else (0.5,):
        y = height * (level + (0.14 if level != 0.5 else 0.3) * _trace(rng, t) * rng.uniform(0.6, 1))
        points = list(zip((width * t).tolist(), y.tolist()))
        marks.line(face, points, paint.lighter(glow, 0.6), 0.008)
        marks.line(face, points, glow, 0.004)
    return face


def _scope_face(rng: Rng, width: float, height: float, color: int) -> tuple[Texture, list[Part]]:
    """The front of an oscilloscope and its knobs, which stand before the plane x = 0, z from its lower edge."""
    face = paint.plastic(rng, (width, height), color)
    ink, dark = (0x2A2C30, 0x33363A) if sum(paint.bgr(color)) > 330 else (0xE0E2E0, 0x0E0F10)
    margin, screen_w = 0.045 * width, rng.uniform(0.47, 0.56) * width
    screen_h = min(0.8 * screen_w, 0.72 * height)
    top = 0.13 * height
    rim = 0.02
    marks.text(face, str(rng.choice(("TEKSCOPE 465", "HM 203", "OS-2100A", "2235 100MHz", "V-212"))),
               (margin, 0.09 * height), 0.045 * height, ink, bold=True)  # fmt: skip
    marks.rectangle(face, (margin - rim, top - rim, screen_w + 2 * rim, screen_h + 2 * rim), dark)
    marks.inlay(face, (margin, top, screen_w, screen_h), _scope_screen(rng, screen_w, screen_h))
    right = 2 * margin + screen_w
    field = width - right - 0.6 * margin
    columns = 3
    step = field / columns
    cap = int(rng.choice(np.asarray((0x2B2B2D, 0x55585C, 0x1E3350))))
    knobs: list[Part] = []
    rows = 4
    for row in range(rows):
        y = top + (row + 0.4) * (0.84 * height - top) / rows
        for column in range(columns):
            at = (right + (column + 0.5) * step, y)
            radius = step * (0.33 if row in (0, 2) else 0.22)
            marks.dial(face, at, radius, rng.uniform(2.5, 7), cap, ink)
            knobs += knob(radius * 0.85, 0.022, cap, (0, at[0] - width / 2, height - y), 10)
        marks.line(face, [(right, y - 0.1 * height), (width - 0.6 * margin, y - 0.1 * height)], ink, 0.002)
    keys = int(rng.integers(5, 8))
    for i in range(keys):
        at_x = margin + (i + 0.2) * screen_w / keys
        marks.button(face, (at_x, top + screen_h + 0.06 * height, 0.4 * screen_w / keys, 0.035 * height), 0xD8D4C8)
    for x in (right + 0.5 * step, right + 1.5 * step, right + 2.5 * step):
        marks.rings(
            face, (x, 0.92 * height), [(0.016, 0x1A1A1A), (0.013, 0xC8CACC), (0.007, 0x1A1A1A), (0.003, 0xD0B060)]
        )
    return paint.edged(face, 0.012, 0.3), knobs


def oscilloscope(rng: Rng) -> list[Part]:
    """An analog oscilloscope on a low, closed trolley."""
    depth, width, height = varied(rng, OSCILLOSCOPE)
    wheel, scope_h = 0.035, rng.uniform(0.56, 0.62) * height
    cart_top = height - scope_h - 0.02
    color = paint.pick(rng, (0xD9D4C4, 0xC4C8CA, 0x9FB0BC, 0x5A6068))
    metal = paint.painted_metal(rng, (width, cart_top), paint.pick(rng, (0x8A9096, 0xB8B4A8, 0x3C4046)))
    door = metal.copy()
    marks.panel(door, (0.02, 0.02, width - 0.04, cart_top - wheel - 0.06))
    parts = castors(depth, width, wheel)
    parts += standing_box((depth, width, cart_top - 1.6 * wheel), metal, {"front": door}, 1.6 * wheel)
    case = paint.painted_metal(rng, (depth, scope_h), paint.lighter(color, 0.85))
    marks.slots(case, (0.06, 0.05, depth - 0.14, 0.3 * scope_h), 6)
    face, knobs = _scope_face(rng, width * 0.97, scope_h, color)
    parts += standing_box((depth * 0.97, width * 0.97, scope_h), case, {"front": face}, cart_top + 0.02)
    parts += standing_box((depth * 0.8, width * 0.8, 0.02), plain(0x202022), z=cart_top)
    parts += placed(knobs, (depth * 0.97 / 2, 0, cart_top + 0.02))
    return parts


def _driver(radius: float, cone: int, metal: bool, rng: Rng) -> list[Part]:
    """A loudspeaker chassis: rim, rubber surround, cone, dust cap; its plane at z = 0."""
    ring = plain(0x9A9C9E) if metal else plain(0x2A2A2C)
    inner = paint.flat((0.1, 0.1), cone)
    inner = paint.toned(inner, np.linspace(1.15, 0.5, inner.shape[0], dtype=np.float32)[:, None])
    rim = [(1.0, 0), (1.0, 0.012 / radius), (0.9, 0.016 / radius), (0.88, 0.006 / radius)]
    surround = [(0.88, 0.0), (0.82, 0.015 / radius), (0.74, 0.0)]
    bowl = [(0.74, 0.0), (0.3, -0.0005 / radius)]
    cap = [(0.3, 0.0), (0.22, 0.05), (0.12, 0.075), (0.0, 0.085)]
    cap_color = plain(0x1A1A1C if rng.random() < 0.5 else paint.lighter(cone, 1.5))
    pieces = ((rim, ring), (surround, plain(0x101012)), (bowl, inner), (cap, cap_color))
    return [lathe(np.asarray(profile) * radius, texture, 28) for profile, texture in pieces]


def loudspeaker(rng: Rng) -> list[Part]:
    """A floor-standing box with two to four drivers."""
    depth, width, height = varied(rng, LOUDSPEAKER)
    veneer = bool(rng.random() < 0.6)
    wood = paint.pick(rng, (0x7A4A28, 0x9C6B3E, 0x4A2E1E, 0xB98A58))
    lacquer = paint.pick(rng, (0x1C1C1E, 0x26282C, 0xD8D6D0))
    side = paint.wood(rng, (depth, height), wood, True) if veneer else paint.plastic(rng, (depth, height), lacquer)
    front_color = paint.pick(rng, (0x1A1A1C, 0x242426)) if veneer or rng.random() < 0.6 else lacquer
    front = paint.edged(paint.plastic(rng, (width, height), front_color), 0.01)
    woofers = int(rng.integers(1, 4))
    woofer_r = min(0.44 * width, 0.62 * height / (2.2 * woofers))
    cone = int(rng.choice(np.asarray((0x232325, 0x3A3A3C, 0xC9B458, 0xD6D6D2, 0x8C8F94))))
    x = depth / 2
    parts = []
    z = height - 0.3 * width
    parts += forward(_driver(0.17 * width, cone, True, rng), (x, 0, z))
    z -= 0.24 * width
    for _ in range(woofers):
        z -= woofer_r
        marks.disc(front, (width / 2, height - z), woofer_r * 1.03, 0x0A0A0A)
        parts += forward(_driver(woofer_r, cone, bool(rng.random() < 0.5), rng), (x, 0, z))
        z -= 1.15 * woofer_r
    port = 0.11 * width
    if z > 0.12 + port:
        marks.rings(front, (width / 2, height - z + 0.5 * port), [(1.25 * port, 0x3A3A3C), (port, 0x040404)])
    marks.label(front, str(rng.choice(("SONUS", "ACOUSTA", "KLANG 3", "MX-200"))),
                (0.36 * width, height - 0.06, 0.28 * width, 0.022), 0x8E9092, 0x101010)  # fmt: skip
    back = paint.plastic(rng, (width, height), 0x1C1C1E)
    marks.rectangle(back, (0.3 * width, 0.75 * height, 0.4 * width, 0.12 * height), 0x2E2E30)
    for side_x, color in ((0.42, 0xC02020), (0.58, 0x101010)):
        marks.disc(back, (side_x * width, 0.81 * height), 0.014, color)
    plinth = standing_box((depth, width, 0.03), plain(0x141416))
    return plinth + standing_box((depth, width, height - 0.03), side, {"front": front, "back": back}, 0.03) + parts


KINDS = (
    Kind("oscilloscope", "oscilloscope", OSCILLOSCOPE, oscilloscope),
    Kind("loudspeaker", "loudspeaker", LOUDSPEAKER, loudspeaker),
)
