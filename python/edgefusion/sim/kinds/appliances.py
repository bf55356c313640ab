# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What warms, cools or lights a room."""

from __future__ import annotations

import cv2
import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import forward, knob, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, prism, standing_box
from edgefusion.sim.paint import Rng

SPACE_HEATER: Size = (0.24, 0.46, 0.62)
ELECTRIC_FAN: Size = (0.32, 0.60, 0.64)
FLOOR_LAMP: Size = (0.42, 0.42, 1.40)


def _glowing(rng: Rng, width: float, height: float) -> Texture:
    """A reflector behind glowing bars."""
    back = paint.brushed_metal(rng, (width, height), 0xB07850)
    bars = int(rng.integers(2, 4))
    y = np.arange(back.shape[0], dtype=np.float32) / back.shape[0]
    glow = sum(np.exp(-(((y - (i + 0.5) / bars) * bars / 0.3) ** 2)) for i in range(bars))
    tint = np.array([20, 90, 255], np.float32)
    back = np.asarray(np.clip(back * 0.5 + np.asarray(glow)[:, None, None] * tint, 0, 255), np.uint8)
    for i in range(bars):
        y_bar = (i + 0.5) / bars * height
        marks.line(back, [(0, y_bar), (width, y_bar)], 0xFF6A18, 0.02)
        marks.line(back, [(0, y_bar), (width, y_bar)], 0xFFE29A, 0.010)
    return back


def space_heater(rng: Rng) -> list[Part]:
    """An electric heater: glowing bars behind a wire grille, a knob, a closed base."""
    depth, width, height = varied(rng, SPACE_HEATER)
    color = paint.pick(rng, (0xE6E2D8, 0xC8CCD0, 0x3A3C40, 0xB89A78, 0x7C2A20))
    case = paint.painted_metal(rng, (width, height), color)
    face = case.copy()
    window = (0.07 * width, 0.10 * height, 0.86 * width, 0.62 * height)
    marks.inlay(face, window, _glowing(rng, window[2], window[3]))
    marks.panel(face, window, 0.008, raised=False)
    low = 0.83 * height
    marks.rectangle(face, (0.07 * width, low - 0.06 * height, 0.86 * width, 0.12 * height), paint.lighter(color, 0.75))
    marks.dial(face, (0.2 * width, low), 0.028, rng.uniform(3, 6))
    for i in range(3):
        marks.button(face, ((0.5 + 0.13 * i) * width, low - 0.012, 0.03, 0.024), (0xC03020, 0xE0E0DC, 0x303030)[i])
    back = case.copy()
    marks.slots(back, (0.1 * width, 0.12 * height, 0.8 * width, 0.5 * height), 14)
    foot = 0.05
    parts = standing_box((depth, width, foot), plain(0x222224))
    parts += standing_box((0.9 * depth, width, height - foot), case, {"front": face, "back": back}, foot)
    wire = plain(0xC9CBCE if rng.random() < 0.6 else 0x2A2A2A)
    front, z_top, z_low = 0.45 * depth, height - window[1], height - window[1] - window[3]
    scale = (height - foot) / height
    z_top, z_low = foot + z_top * scale, foot + z_low * scale
    wires = int(rng.integers(9, 14))
    for i in range(wires):
        z = z_low + (i + 0.5) / wires * (z_top - z_low)
        parts += box((0.005, 0.88 * width, 0.005), (front + 0.02, 0, z), wire)
    for y in np.linspace(-0.43, 0.43, 3) * width:
        parts += box((0.006, 0.006, z_top - z_low), (front + 0.016, float(y), (z_top + z_low) / 2), wire)
    parts += knob(0.024, 0.02, 0x202022, (front, (0.2 - 0.5) * width, foot + (height - low) * scale))
    return parts


def _blades(rng: Rng, face: Texture, radius: float, color: int) -> None:
    """Swept blades around a hub, each lighter towards its leading edge."""
    count, sweep = int(rng.integers(3, 7)), rng.uniform(0.3, 0.9)
    wide, start = rng.uniform(0.55, 0.8) * 2 * np.pi / count, rng.uniform(0, 6)
    out = np.linspace(0.2, 0.9, 8)
    for i in range(count):
        for j, gain in enumerate((0.6, 0.8, 1.0, 1.2)):
            edge = start + i * 2 * np.pi / count + sweep * out
            angles = np.concatenate([edge + j * wide / 4, (edge + wide)[::-1]])
            reach = np.concatenate([out, out[::-1]]) * radius
            points = np.stack([radius + reach * np.cos(angles), radius + reach * np.sin(angles)], axis=1)
            marks.polygon(face, [(x, y) for x, y in points.tolist()], paint.lighter(color, gain))


def _fan_face(rng: Rng, radius: float, wire: int) -> Texture:
    """What one sees through a fan's guard, and the guard's wires: [2 radius, 2 radius]."""
    face = paint.flat((2 * radius, 2 * radius), 0x1C1E20)
    _blades(rng, face, radius, paint.pick(rng, (0x8C9096, 0xB8C4CC, 0x3C4046, 0x5A7CA8, 0xC8C8C0, 0x3A6A5A)))
    spokes, swirl, loops = int(rng.integers(16, 49)), rng.uniform(-0.7, 0.7), int(rng.integers(3, 11))
    out, turns = np.linspace(0.2, 0.97, 6), np.linspace(0, 2 * np.pi, 49)
    wires = [(out, i * 2 * np.pi / spokes + swirl * out) for i in range(spokes)]
    wires += [(np.full(49, reach), turns) for reach in np.linspace(0.25, 0.97, loops)]
    for reach, angle in wires:
        points = radius * np.stack([1 + reach * np.cos(angle), 1 + reach * np.sin(angle)], axis=1)
        marks.line(face, [(x, y) for x, y in points.tolist()], wire, 0.003)
    marks.rings(face, (radius, radius), [(0.26 * radius, 0x101214), (0.24 * radius, paint.lighter(wire, 0.8))])
    return face


def _drum_fan(rng: Rng, size: Size, color: int, wire: int) -> list[Part]:
    """A round fan in a sheet-metal barrel between two cheeks of a low stand."""
    depth, width, height = size
    radius, foot = min(0.5 * width - 0.02, 0.48 * height), rng.uniform(0.08, 0.14)
    shell = paint.shaded(paint.painted_metal(rng, (1.0, 0.8 * depth), color))
    turns = np.arange(32) * 2 * np.pi / 32
    outline = radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    half = 0.4 * depth
    barrel = prism(0.97 * outline, -half, half - 0.02, shell, _fan_face(rng, 0.97 * radius, wire))
    lip = [(0.97 * radius, -half), (radius, -half), (radius, half), (0.95 * radius, half), (0.95 * radius, half - 0.02)]
    barrel.append(lathe(lip, shell, 32))
    barrel += placed(drum(0.22 * radius, half - 0.02, half + 0.01, plain(wire), segments=16))
    z = height - radius
    stand = paint.painted_metal(rng, (width, foot), paint.lighter(color, 0.7))
    parts = standing_box((depth, width, foot), stand) + forward(barrel, (0, 0, z))
    for side in (-1, 1):
        at = (0, side * (width / 2 - 0.01), (foot + z) / 2)
        parts += box((0.3 * depth, 0.02, z - foot + 0.08), at, plain(paint.lighter(color, 0.6)))
    return parts


def _box_fan(rng: Rng, size: Size, color: int, wire: int) -> list[Part]:
    """A square fan: a frame with a round opening, two feet as wide as itself, a knob in a corner."""
    depth, width, height = size
    foot = 0.03
    tall = height - foot
    sheet = paint.plastic(rng, (width, tall), color)
    face = sheet.copy()
    radius = 0.46 * min(width, tall)
    disc = _fan_face(rng, radius, wire)
    outside = np.ones(disc.shape[:2], np.uint8)
    cv2.circle(outside, (disc.shape[1] // 2, disc.shape[0] // 2), disc.shape[0] // 2, 0, -1)
    disc[outside > 0] = paint.bgr(color)
    marks.panel(face, (0.01, 0.01, width - 0.02, tall - 0.02), 0.004)
    marks.inlay(face, (width / 2 - radius, tall / 2 - radius, 2 * radius, 2 * radius), disc)
    parts = standing_box((0.9 * depth, width, tall), sheet, {"front": face, "back": face}, foot)
    parts += standing_box((depth, width, foot), plain(0x2A2C2E))
    x = 0.45 * depth
    parts += forward(drum(0.2 * radius, 0, 0.02, plain(wire), segments=16), (x, 0, foot + tall / 2))
    return parts + knob(0.022, 0.02, 0x202022, (x, 0.43 * width, height - 0.07 * width))


def electric_fan(rng: Rng) -> list[Part]:
    """A floor fan with a guard of wires, in a round barrel or a square frame."""
    size = varied(rng, ELECTRIC_FAN)
    color = paint.pick(rng, (0xE8E6E0, 0xC8CCD0, 0x2A2C30, 0x3A5A86, 0x6A7078, 0xB83A2C, 0xD8C8A8))
    wire = paint.pick(rng, (0xD8DCE0, 0xB0B4B8, 0xF0F0EC, 0x3A3C40))
    return (_drum_fan if rng.random() < 0.6 else _box_fan)(rng, size, color, wire)


def _shade_cloth(rng: Rng, width: float, height: float, lit: bool) -> Texture:
    """Fabric around a lamp, pleated or plain, brightest about the bulb where it is lit."""
    color = paint.pick(rng, (0xE8DCC0, 0xF0EADC, 0xD8C8A8, 0xC8B090, 0xB05040, 0x50687A, 0x7A8A60))
    cloth = paint.fabric(rng, (width, height), color)
    if rng.random() < 0.5:
        across = np.arange(cloth.shape[1], dtype=np.float32)[None, :] / paint.PX_PER_M
        cloth = paint.toned(cloth, 1 + 0.12 * np.sin(2 * np.pi * across / rng.uniform(0.015, 0.03)))
    if lit:
        down = np.linspace(0, 1, cloth.shape[0], dtype=np.float32)[:, None]
        cloth = paint.toned(cloth, 1 + 0.35 * np.exp(-(((down - 0.55) / 0.3) ** 2)))
    hem = paint.lighter(color, 0.7)
    marks.rectangle(cloth, (0, 0, width, 0.012), hem)
    marks.rectangle(cloth, (0, height - 0.012, width, 0.012), hem)
    return cloth


def floor_lamp(rng: Rng) -> list[Part]:
    """A shade on a thin pole with a round foot."""
    _, width, height = varied(rng, FLOOR_LAMP)
    radius, tall = width / 2, rng.uniform(0.24, 0.34)
    tip, lit = rng.uniform(0.5, 0.9) * radius, bool(rng.random() < 0.6)
    pole, foot = rng.uniform(0.010, 0.016), rng.uniform(0.62, 0.75) * radius
    metal = plain(paint.pick(rng, (0xB89A58, 0x2A2A2C, 0xC0C4C8, 0x6A4A30, 0xE8E6E0)))
    low = height - tall
    stand = [(0, 0), (foot, 0), (foot, 0.015), (0.9 * foot, 0.03), (2 * pole, 0.045), (pole, 0.07), (pole, low)]
    bead = rng.uniform(0.3, 0.8) * low
    ring = [(pole, bead), (1.8 * pole, bead + 0.015), (1.8 * pole, bead + 0.03), (pole, bead + 0.045)]
    cloth = _shade_cloth(rng, np.pi * radius, tall, lit)
    inner = plain(0xFFF4D8 if lit else 0xC8C0B0)
    parts = [lathe(stand, metal, 24), lathe(ring, metal, 16), lathe([(radius, low), (tip, height)], cloth, 32)]
    parts.append(lathe([(0.99 * tip, height), (0.99 * radius, low)], inner, 32))
    parts += drum(pole, low, height - 0.04, metal, segments=12)
    bulb = [(0.02, low + 0.05), (0.035, low + 0.1), (0.02, low + 0.14), (0, low + 0.14)]
    return [*parts, lathe(bulb, plain(0xFFFFF0 if lit else 0xD8D8D4), 12)]


KINDS = (
    Kind("space heater", "space heater", SPACE_HEATER, space_heater),
    Kind("electric fan", "electric fan", ELECTRIC_FAN, electric_fan),
    Kind("floor lamp", "lampshade", FLOOR_LAMP, floor_lamp),
)
