# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is drawn onto a material, in place: text, panels, slots, screws, dials, buttons.

Positions are (x, y) in metres from the texture's upper left corner, rectangles (x, y, width, height), as in `paint`.
"""

from __future__ import annotations

import math
from typing import Sequence, Tuple

import cv2
import numpy as np

from edgefusion.sim.mesh import Texture
from edgefusion.sim.paint import PX_PER_M, Rng, bgr, lighter, px

At = Tuple[float, float]
Rect = Tuple[float, float, float, float]
_SHIFT = 4  # OpenCV's fixed point: 1/16 pixel


def _fixed(metres: float) -> int:
    return round(metres * PX_PER_M * (1 << _SHIFT))


def rectangle(texture: Texture, rect: Rect, color: int) -> None:
    """A filled rectangle."""
    x, y, w, h = rect
    cv2.rectangle(texture, (px(x), px(y)), (px(x + w) - 1, px(y + h) - 1), bgr(color), -1)


def inlay(texture: Texture, rect: Rect, material: Texture) -> None:
    """Another material, resized into the rectangle; what lies outside the texture is cut off."""
    x, y, w, h = rect
    target = texture[max(0, px(y)) : px(y + h), max(0, px(x)) : px(x + w)]
    if target.size:
        target[:] = cv2.resize(material, (target.shape[1], target.shape[0]), interpolation=cv2.INTER_AREA)


def line(texture: Texture, points: Sequence[At], color: int, width_m: float = 0.003) -> None:
    """A polyline."""
    corners = np.array([[_fixed(x), _fixed(y)] for x, y in points], np.int32)
    cv2.polylines(texture, [corners], False, bgr(color), max(1, px(width_m)), cv2.LINE_AA, _SHIFT)


def polygon(texture: Texture, points: Sequence[At], color: int) -> None:
    """A filled polygon."""
    corners = np.array([[_fixed(x), _fixed(y)] for x, y in points], np.int32)
    cv2.fillPoly(texture, [corners], bgr(color), cv2.LINE_AA, _SHIFT)


def disc(texture: Texture, at: At, radius_m: float, color: int) -> None:
    """A filled circle."""
    centre = (_fixed(at[0]), _fixed(at[1]))
    cv2.circle(texture, centre, max(1, _fixed(radius_m)), bgr(color), -1, cv2.LINE_AA, _SHIFT)


def rings(texture: Texture, at: At, radii_colors: Sequence[tuple[float, int]]) -> None:
    """Concentric circles (radius [m], colour), from the largest to the smallest."""
    for radius_m, color in radii_colors:
        disc(texture, at, radius_m, color)


def panel(texture: Texture, rect: Rect, gap_m: float = 0.004, raised: bool = True) -> None:
    """The outline of a drawer, door or plate: a dark gap around, a bright edge on the side of the light."""
    x, y, w, h = (px(v) for v in rect)
    g = max(1, px(gap_m))
    inner = texture[y + g : y + h - g, x + g : x + w - g].copy()
    texture[y : y + h, x : x + w] = (texture[y : y + h, x : x + w] * 0.3).astype(np.uint8)
    texture[y + g : y + h - g, x + g : x + w - g] = inner
    upper, lower = (1.25, 0.75) if raised else (0.75, 1.2)
    for rows, gain in (((y + g, y + 2 * g), upper), ((y + h - 2 * g, y + h - g), lower)):
        strip = texture[rows[0] : rows[1], x + g : x + w - g]
        strip[:] = np.clip(strip * gain, 0, 255).astype(np.uint8)


def shadow(texture: Texture, rect: Rect, drop_m: float = 0.008, strength: float = 0.5) -> None:
    """The soft shadow that something in the rectangle throws downwards."""
    x, y, w, h = rect
    dark = np.zeros(texture.shape[:2], np.float32)
    cv2.rectangle(dark, (px(x), px(y + drop_m)), (px(x + w), px(y + h + drop_m)), 1.0, -1)
    soft = cv2.GaussianBlur(dark, (0, 0), max(0.8, px(drop_m) / 2)).reshape(dark.shape)
    texture[:] = np.asarray(texture * (1 - strength * soft[..., None]), np.uint8)


def text(texture: Texture, words: str, at: At, height_m: float, color: int, bold: bool = False) -> None:
    """Letters of that height; `at` is the lower left corner of the first."""
    font = cv2.FONT_HERSHEY_DUPLEX if bold else cv2.FONT_HERSHEY_SIMPLEX
    scale = height_m * PX_PER_M / 21  # Hershey's capitals are 21 pixels high at scale 1
    cv2.putText(texture, words, (px(at[0]), px(at[1])), font, scale, bgr(color), 2 if bold else 1, cv2.LINE_AA)


def label(texture: Texture, words: str, rect: Rect, paper: int = 0xF2F0E8, ink: int = 0x202020) -> None:
    """A paper label or name plate with one line of words."""
    x, y, w, h = rect
    rectangle(texture, rect, paper)
    height = min(0.5 * h, 1.1 * w / max(1, len(words)))
    text(texture, words, (x + 0.08 * w, y + 0.5 * (h + height)), height, ink)


def screw(rng: Rng, texture: Texture, at: At, radius_m: float = 0.005, color: int = 0x8A8A88) -> None:
    """A slotted screw head, turned anyhow."""
    rings(texture, at, [(radius_m * 1.25, 0x303030), (radius_m, color)])
    turn = rng.uniform(0, math.pi)
    dx, dy = 0.7 * radius_m * math.cos(turn), 0.7 * radius_m * math.sin(turn)
    line(texture, [(at[0] - dx, at[1] - dy), (at[0] + dx, at[1] + dy)], 0x2A2A2A, radius_m * 0.35)


def dial(
    texture: Texture, at: At, radius_m: float, angle: float, cap: int = 0x2B2B2D, scale: int | None = 0x303030
) -> None:
    """A round knob with its pointer at `angle` (0 = right, clockwise) and, where `scale` is a colour, ticks around."""
    x, y = at
    if scale is not None:
        for tick in np.linspace(math.radians(135), math.radians(405), 11):
            c, s = math.cos(tick), math.sin(tick)
            ends = [(x + r * radius_m * c, y + r * radius_m * s) for r in (1.25, 1.5)]
            line(texture, ends, scale, 0.002)
    disc(texture, (x + 0.1 * radius_m, y + 0.25 * radius_m), 1.1 * radius_m, 0x1A1A1A)
    rings(texture, at, [(radius_m, lighter(cap, 0.8)), (0.8 * radius_m, lighter(cap, 1.4)), (0.7 * radius_m, cap)])
    tip = (x + 0.8 * radius_m * math.cos(angle), y + 0.8 * radius_m * math.sin(angle))
    line(texture, [at, tip], 0xF0F0F0, radius_m * 0.2)


def button(texture: Texture, rect: Rect, color: int) -> None:
    """A raised key with a dark surround."""
    x, y, w, h = rect
    rim = min(w, h) * 0.12
    rectangle(texture, (x - rim, y - rim, w + 2 * rim, h + 2 * rim), 0x1E1E1E)
    rectangle(texture, rect, color)
    rectangle(texture, (x, y, w, h * 0.3), lighter(color, 1.2))
    rectangle(texture, (x, y + h * 0.85, w, h * 0.15), lighter(color, 0.7))


def slots(texture: Texture, rect: Rect, count: int, upright: bool = False, color: int = 0x141414) -> None:
    """Ventilation slots, `count` of them with bars of the same width between."""
    x, y, w, h = rect
    for i in range(count):
        if upright:
            rectangle(texture, (x + w * (i + 0.25) / count, y, 0.5 * w / count, h), color)
        else:
            rectangle(texture, (x, y + h * (i + 0.25) / count, w, 0.5 * h / count), color)


def frame(texture: Texture, rect: Rect, color: int, width_m: float) -> None:
    """A rectangle's border, inside its edge."""
    x, y, w, h = rect
    for top in (y, y + h - width_m):
        rectangle(texture, (x, top, w, width_m), color)
    for left in (x, x + w - width_m):
        rectangle(texture, (left, y, width_m, h), color)


def hatched(texture: Texture, rect: Rect, color: int, width_m: float, lean: float = 1.0) -> None:
    """Slanting warning stripes of that width with gaps as wide; `lean` is how far they move sideways per height."""
    x, y, w, h = rect
    shift = lean * h
    band = texture[px(y) : px(y + h), px(x) : px(x + w)].copy()
    left = -abs(shift)
    while left < w + abs(shift):
        foot = left - shift
        polygon(band, [(left, 0), (left + width_m, 0), (foot + width_m, h), (foot, h)], color)
        left += 2 * width_m
    texture[px(y) : px(y + h), px(x) : px(x + w)] = band
