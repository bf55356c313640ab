# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A car, painted from its side, its front, its back and from above."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.car_body import CAR, MIRROR, BodyShape, Points, body_shape, painted
from edgefusion.sim.kinds.form import forward
from edgefusion.sim.kinds.kind import Kind
from edgefusion.sim.mesh import Part, Texture, box, lathe, placed, plain
from edgefusion.sim.paint import Rng

_SCALE = 0.28
"""Metres on a car's textures per metre of the car: they are larger than others and need less detail."""

_COLORS = (0xB01818, 0x1C3C7C, 0xC8CCD0, 0xE8E8E4, 0x4A5056, 0x2C6A50, 0x3A78B0, 0x8C9094, 0xD8A018, 0x6A2030)
_GLASS = 0x1C242A


def _sheet(rng: Rng, width: float, height: float, color: int) -> Texture:
    """Lacquer that mirrors the sky above and the road below."""
    return paint.shaded(paint.dirt(rng, paint.flat((width * _SCALE, height * _SCALE), color), 0.02), 1.15, 0.75)


def _fill(texture: Texture, points: Points, color: int) -> None:
    marks.polygon(texture, [(float(x), float(y)) for x, y in points * _SCALE], color)


def _stroke(texture: Texture, points: Points, color: int, width_m: float) -> None:
    marks.line(texture, [(float(x), float(y)) for x, y in points * _SCALE], color, width_m * _SCALE)


def _side(rng: Rng, shape: BodyShape, color: int) -> Texture:
    """Windows with pillars, doors with handles, wheel arches, sill."""
    depth, _, height = shape.size
    face = _sheet(rng, depth, height, color)

    def at(along: float, z: float) -> tuple[float, float]:
        return (1 - along) * depth / 2, height - z

    belt, roof = shape.belt + 0.03, 0.93 * height
    corners = ((shape.hood_end - 0.06, belt), (shape.roof_start - 0.01, roof),
               (shape.roof_end + 0.02, roof), (shape.tail + 0.07, belt))  # fmt: skip
    _glass(face, np.array([at(*corner) for corner in corners]))
    pillars = (shape.roof_start - 0.3, shape.roof_start - 0.72)
    for along in pillars:
        _stroke(face, np.array([at(along, roof), at(along + 0.03, belt)]), paint.lighter(color, 0.6), 0.07)
        _stroke(
            face, np.array([at(along + 0.03, belt), at(along + 0.03, shape.sill)]), paint.lighter(color, 0.4), 0.014
        )
        handle = np.array([at(along + 0.07, belt - 0.12), at(along + 0.14, belt - 0.12)])
        _stroke(face, handle, 0x1A1A1C, 0.035)
        _stroke(face, handle - (0, 0.008), paint.lighter(color, 1.2), 0.02)
    hinge = shape.hood_end - 0.1
    _stroke(face, np.array([at(hinge, belt), at(hinge, shape.sill)]), paint.lighter(color, 0.4), 0.014)
    _stroke(face, np.array([at(0.9, belt - 0.2), at(-0.92, belt - 0.16)]), paint.lighter(color, 1.25), 0.02)
    _stroke(face, np.array([at(0.95, 0.27 * height), at(-0.95, 0.27 * height)]), 0x26282A, 0.05)
    _stroke(face, np.array([at(1, shape.sill), at(-1, shape.sill)]), 0x1A1A1C, 0.12)
    for along in shape.axles:
        x, y = at(along, shape.wheel)
        marks.disc(face, (x * _SCALE, y * _SCALE), 1.17 * shape.wheel * _SCALE, 0x0A0A0B)
    _fill(face, np.array([at(0.98, shape.nose - 0.1), at(0.86, shape.nose - 0.06), at(0.88, shape.nose - 0.18),
                          at(0.98, shape.nose - 0.18)]), 0xDCE4E8)  # fmt: skip
    _fill(face, np.array([at(-0.99, belt - 0.08), at(-0.92, belt - 0.08), at(-0.92, belt - 0.3),
                          at(-0.99, belt - 0.3)]), 0xA01018)  # fmt: skip
    return face


def _glass(face: Texture, pane: Points) -> None:
    """A window with the sky mirrored in its upper part and a dark rubber around."""
    _fill(face, pane, 0x0C0D0E)
    middle = pane.mean(axis=0)
    inner = (pane - middle) * (0.975, 0.94) + middle
    low, high = inner[:, 1].max(), inner[:, 1].min()
    mask = np.zeros_like(face)
    _fill(mask, inner, 0xFFFFFF)
    rows = (np.arange(face.shape[0]) / (paint.PX_PER_M * _SCALE) - high) / (low - high)
    sky = np.clip(1 - rows, 0, 1)[:, None, None] ** 1.5
    shade = np.array(paint.bgr(_GLASS)) * (1 - 0.6 * sky) + np.array(paint.bgr(0x9CB0BC)) * 0.6 * sky
    face[:] = np.where(mask > 127, shade, face).astype(np.uint8)


def _windscreen(shape: BodyShape, face: Texture, seats: tuple[float, ...]) -> None:
    """The pane across the cabin, seen from the front or the back, headrests behind it."""
    _, width, height = shape.size
    low, high = height - shape.belt - 0.035, 0.065 * height
    middle = width / 2
    corners = ((-0.325, high), (0.325, high), (0.42, low), (-0.42, low))
    _glass(face, np.array([(middle + share * width, y) for share, y in corners]))
    for seat in seats:
        x = middle + seat * width
        headrest = np.array([(-0.12, -0.28), (0.12, -0.28), (0.15, -0.02), (-0.15, -0.02)])
        _fill(face, headrest + np.array((x, low)), 0x12161A)
    for x in (middle - 0.3 * width, middle + 0.02 * width):
        _stroke(face, np.array([(x, low), (x + 0.28 * width, low - 0.05)]), 0x08080A, 0.018)


def _plate(rng: Rng, face: Texture, shape: BodyShape, z: float) -> None:
    """A number plate in the middle at height z."""
    _, width, height = shape.size
    letters = "".join(chr(65 + int(rng.integers(26))) for _ in range(2))
    rect = tuple(v * _SCALE for v in (width / 2 - 0.24, height - z - 0.05, 0.48, 0.11))
    marks.label(face, f"{letters} {int(rng.integers(100, 9999))}", rect, 0xF0F0E8)  # type: ignore[arg-type]


def _headlight(face: Texture, inner: float, outer: float, top: float) -> None:
    """Two round lamps behind a pane between two places across the front, an indicator outside."""
    pane = np.array([(inner, top + 0.01), (outer, top - 0.02), (outer, top + 0.12), (inner, top + 0.14)])
    _fill(face, pane, 0x202224)
    _fill(face, (pane - pane.mean(axis=0)) * (0.94, 0.8) + pane.mean(axis=0), 0xB0BCC4)
    for share in (0.35, 0.7):
        at = ((inner + share * (outer - inner)) * _SCALE, (top + 0.065) * _SCALE)
        marks.rings(face, at, [(0.05 * _SCALE, 0x70787E), (0.042 * _SCALE, 0xE8EEF0), (0.02 * _SCALE, 0xFFFFFF)])
    _stroke(face, np.array([(outer, top), (outer, top + 0.12)]), 0xF09020, 0.03)


def _grille(rng: Rng, face: Texture, middle: float, half: float, top: float) -> None:
    """Bars, a badge, a bright surround."""
    opening = np.array([(-1, 0), (1, 0), (0.88, 0.16), (-0.88, 0.16)]) * (half, 1) + (middle, top - 0.01)
    _fill(face, opening, 0xB8BCC0)
    _fill(face, (opening - opening.mean(axis=0)) * (0.96, 0.84) + opening.mean(axis=0), 0x0C0D0E)
    bars = int(rng.integers(2, 5))
    for i in range(bars):
        y = top + 0.14 * (i + 0.5) / bars
        _stroke(face, np.array([(middle - 0.88 * half, y), (middle + 0.88 * half, y)]), 0x54585C, 0.01)
    marks.rings(face, (middle * _SCALE, (top + 0.07) * _SCALE), [(0.042 * _SCALE, 0xD0D4D8), (0.03 * _SCALE, 0x3A4A6A)])


def _bumper(face: Texture, shape: BodyShape, color: int, bare: bool) -> None:
    """Painted as the car, or bare plastic; the intake and the fog lights in it."""
    _, width, height = shape.size
    low = height - shape.sill
    if bare:
        _fill(face, np.array([(0, low - 0.27), (width, low - 0.27), (width, low + 0.1), (0, low + 0.1)]), 0x2C2E30)
    _stroke(face, np.array([(0, low - 0.28), (width, low - 0.28)]), paint.lighter(color, 0.35), 0.016)
    intake = np.array([(-0.27, -0.17), (0.27, -0.17), (0.23, 0.0), (-0.23, 0.0)]) * (width, 1) + (width / 2, low)
    _fill(face, intake, 0x0C0D0E)
    for y in (-0.12, -0.06):
        _stroke(face, np.array([(0.3 * width, low + y), (0.7 * width, low + y)]), 0x2A2C2E, 0.012)
    for s in (-1, 1):
        at = ((0.5 + s * 0.33) * width * _SCALE, (low - 0.1) * _SCALE)
        marks.rings(face, at, [(0.06 * _SCALE, 0x141516), (0.042 * _SCALE, 0x98A0A4)])


def _front(rng: Rng, shape: BodyShape, color: int, bare: bool) -> Texture:
    """Windscreen, grille, headlights, bumper, plate."""
    _, width, height = shape.size
    face = _sheet(rng, width, height, color)
    _windscreen(shape, face, (-0.2, 0.2))
    top = height - shape.nose + 0.06
    _stroke(face, np.array([(0.07 * width, top - 0.04), (0.93 * width, top - 0.04)]), paint.lighter(color, 0.4), 0.014)
    _bumper(face, shape, color, bare)
    _grille(rng, face, width / 2, rng.uniform(0.2, 0.24) * width, top)
    for s in (-1, 1):
        _headlight(face, (0.5 + s * 0.25) * width, (0.5 + s * 0.44) * width, top)
    _plate(rng, face, shape, shape.sill + 0.19)
    return face


def _back(rng: Rng, shape: BodyShape, color: int, bare: bool) -> Texture:
    """Rear window, lights, hatch, bumper, plate."""
    _, width, height = shape.size
    face = _sheet(rng, width, height, color)
    _windscreen(shape, face, (-0.22, 0.0, 0.22))
    top = height - shape.belt + 0.06
    for s in (-1, 1):
        x = width / 2 + s * 0.40 * width
        lamp = np.array([(x - 0.09, top), (x + 0.09, top), (x + 0.1, top + 0.26), (x - 0.1, top + 0.26)])
        _fill(face, lamp, 0x8A1018)
        _fill(face, lamp * 0.8 + 0.2 * lamp.mean(axis=0), 0xD82028)
        _fill(face, (lamp - lamp.mean(axis=0)) * (0.8, 0.2) + lamp.mean(axis=0), 0xF4D8C8)
    hatch = ((0.08 * width, top + 0.3), (0.92 * width, top + 0.3))
    _stroke(face, np.array(hatch), paint.lighter(color, 0.4), 0.014)
    strip = np.array([(0.06 * width, top + 0.42), (0.94 * width, top + 0.42)])
    _stroke(face, strip, 0x26282A, 0.2 if bare else 0.08)
    _plate(rng, face, shape, shape.belt - 0.2)
    return face


def _above(rng: Rng, shape: BodyShape, color: int) -> Texture:
    """Hood and roof."""
    depth, width, _ = shape.size
    face = _sheet(rng, width, depth, color)
    for y in (0.28 * width, 0.72 * width):
        x0, x1 = (1 - shape.hood_end) * depth / 2, 0.06 * depth
        _stroke(face, np.array([(y, x0), (y * 0.9 + 0.05 * width, x1)]), paint.lighter(color, 0.7), 0.015)
    return face


def _wheel(rng: Rng, radius: float) -> list[Part]:
    """Tyre and rim, its axis along y, the outer face to the left."""
    tyre, metal = plain(0x1A1A1C), paint.pick(rng, (0xB8BCC0, 0x9CA0A4, 0xD0D4D8))
    rim = paint.shaded(paint.flat((0.6, 0.1), metal), 1.1, 0.8)
    spokes = int(rng.integers(5, 10))
    for i in range(spokes):  # what runs around once is 0.6 wide; the hub is above
        u = 0.6 * i / spokes
        gap = [(u, 0.075), (u + 0.36 / spokes, 0.075), (u + 0.28 / spokes, 0.03), (u + 0.08 / spokes, 0.03)]
        marks.polygon(rim, gap, 0x1E2022)
    parts = [
        lathe([(0, -0.18), (radius, -0.18), (radius, -0.03), (0.92 * radius, 0), (0.66 * radius, -0.006)], tyre, 22),
        lathe([(0.66 * radius, -0.006), (0.6 * radius, -0.025), (0.2 * radius, -0.01), (0, 0.0)], rim, 22),
    ]
    return placed(forward(parts, (0, 0, 0)), yaw=np.pi / 2)


def car(rng: Rng) -> list[Part]:
    """A small family car with five doors."""
    shape = body_shape(rng)
    depth, width, _ = shape.size
    color, bare = paint.pick(rng, _COLORS), bool(rng.random() < 0.5)
    side = _side(rng, shape, color)
    ends = {"front": _front(rng, shape, color, bare), "back": _back(rng, shape, color, bare)}
    around = {"left": side, "right": side, "top": _above(rng, shape, color), "bottom": plain(0x101012)}
    parts = painted(shape, {**ends, **around})
    wheel = _wheel(rng, shape.wheel)
    for along in shape.axles:
        for turn, y in ((0.0, 0.5 * width + 0.005), (np.pi, -0.5 * width - 0.005)):
            parts += placed(wheel, (along * depth / 2, y, shape.wheel), yaw=turn)
    mirror_x, shell = (shape.hood_end - 0.1) * depth / 2, plain(color)
    for s in (-1, 1):
        parts += box((0.1, 0.16, 0.12), (mirror_x, s * (width / 2 + MIRROR - 0.08), shape.belt + 0.08), shell)
    return parts


KINDS = (Kind("car", "minivan", CAR, car),)
