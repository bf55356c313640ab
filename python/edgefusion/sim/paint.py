# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Materials: each returns a new BGR texture of a surface of so many metres, at PX_PER_M.

Sizes are (width, height) in metres, colours 0xRRGGBB. What is drawn onto a material (text, dials, slots) is in
`marks`, in metres from the upper left corner too.
"""

from __future__ import annotations

from typing import Sequence, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.sim.mesh import Texture

Rng = np.random.Generator
Extent = Tuple[float, float]
"""(width, height) of a surface in metres."""

PX_PER_M = 512.0


def px(metres: float) -> int:
    """Metres on a surface in pixels of its texture."""
    return round(metres * PX_PER_M)


def bgr(color: int) -> tuple[int, int, int]:
    """0xRRGGBB as OpenCV takes it."""
    return color & 255, color >> 8 & 255, color >> 16 & 255


def pick(rng: Rng, colors: Sequence[int], spread: float = 0.05) -> int:
    """One of the colours, made lighter or darker and tinted a little."""
    color = np.array(bgr(int(rng.choice(np.asarray(colors)))), float)
    b, g, r = np.clip(color * (1 + rng.normal(0, spread)) + rng.normal(0, 60 * spread, 3), 0, 255).astype(int).tolist()
    return int(r << 16 | g << 8 | b)


def lighter(color: int, factor: float) -> int:
    """The colour with its brightness times `factor`."""
    b, g, r = (min(255, round(c * factor)) for c in bgr(color))
    return r << 16 | g << 8 | b


def flat(size: Extent, color: int) -> Texture:
    """One colour, at the surface's resolution, to draw on."""
    return np.full((max(2, px(size[1])), max(2, px(size[0])), 3), bgr(color), np.uint8)


def toned(texture: Texture, factor: npt.ArrayLike) -> Texture:
    """Brightness times `factor`, which broadcasts to [height, width]."""
    gain = np.broadcast_to(np.asarray(factor, np.float32), texture.shape[:2])
    return np.asarray(np.clip(texture * gain[..., None] + 0.5, 0, 255), np.uint8)


def clouds(rng: Rng, shape: tuple[int, int], cell_px: float) -> npt.NDArray[np.float32]:
    """Smooth noise float32[height, width] about 0, deviation about 1, in cells of that many pixels."""
    h, w = shape
    coarse = rng.normal(0, 1, (max(2, int(h / cell_px) + 2), max(2, int(w / cell_px) + 2))).astype(np.float32)
    return np.asarray(cv2.resize(coarse, (w, h), interpolation=cv2.INTER_CUBIC), np.float32)


def grain(rng: Rng, texture: Texture, strength: float = 0.03) -> Texture:
    """Fine noise, as on cast or powder-coated surfaces."""
    return toned(texture, 1 + strength * clouds(rng, (texture.shape[0], texture.shape[1]), 2.0))


def dirt(rng: Rng, texture: Texture, strength: float = 0.06) -> Texture:
    """Large, soft patches of wear, darker towards the lower edge."""
    h, w = texture.shape[:2]
    rising = np.linspace(0, 1, h, dtype=np.float32)[:, None] ** 3
    return toned(texture, 1 + strength * (clouds(rng, (h, w), max(h, w) / 4) - 2 * rising))


def shaded(texture: Texture, top: float = 1.08, bottom: float = 0.88) -> Texture:
    """A vertical gradient of light."""
    return toned(texture, np.linspace(top, bottom, texture.shape[0], dtype=np.float32)[:, None])


def edged(texture: Texture, width_m: float = 0.02, depth: float = 0.35) -> Texture:
    """Darker towards all edges, as in the corners of a box."""
    h, w = texture.shape[:2]
    y, x = np.arange(h, dtype=np.float32) + 0.5, np.arange(w, dtype=np.float32) + 0.5
    to_edge = np.minimum(np.minimum(y, h - y)[:, None], np.minimum(x, w - x)[None, :])
    return toned(texture, 1 - depth * np.exp(-to_edge / (width_m * PX_PER_M)))


def plastic(rng: Rng, size: Extent, color: int) -> Texture:
    """Moulded plastic: nearly even."""
    return shaded(dirt(rng, grain(rng, flat(size, color), 0.015), 0.02))


def painted_metal(rng: Rng, size: Extent, color: int) -> Texture:
    """Powder-coated sheet: fine grain, a soft reflection, worn below."""
    texture = dirt(rng, grain(rng, flat(size, color), 0.025), 0.05)
    h = texture.shape[0]
    shine = np.exp(-(((np.arange(h, dtype=np.float32) / h - rng.uniform(0.1, 0.4)) / 0.2) ** 2))
    return toned(texture, 0.97 + 0.08 * shine[:, None])


def brushed_metal(rng: Rng, size: Extent, color: int = 0xB4B6B8) -> Texture:
    """Fine horizontal strokes and a soft reflection across."""
    texture = flat(size, color)
    h, w = texture.shape[:2]
    strokes = cv2.blur(rng.normal(0, 1, (h, w)).astype(np.float32), (31, 1)).reshape(h, w)
    shine = clouds(rng, (1, w), w / 3)
    return toned(texture, 1 + 0.25 * strokes + 0.06 * shine)


def wood(rng: Rng, size: Extent, color: int, upright: bool = False) -> Texture:
    """Veneer, its grain along the width (or the height, where upright)."""
    texture = flat(size if not upright else (size[1], size[0]), color)
    h, w = texture.shape[:2]
    y = np.arange(h, dtype=np.float32)[:, None] / (PX_PER_M * 0.03)
    warp = clouds(rng, (h, w), 0.25 * PX_PER_M)
    rings = np.sin(2 * np.pi * (y + 0.8 * warp) + rng.uniform(0, 6))
    fibres = cv2.blur(rng.normal(0, 1, (h, w)).astype(np.float32), (41, 1)).reshape(h, w)
    texture = toned(texture, 1 + 0.07 * rings + 0.35 * fibres + 0.05 * warp)
    return np.ascontiguousarray(np.rot90(texture)) if upright else texture


def fabric(rng: Rng, size: Extent, color: int) -> Texture:
    """A plain weave."""
    texture = flat(size, color)
    h, w = texture.shape[:2]
    weave = ((np.arange(h)[:, None] // 2 + np.arange(w)[None, :] // 2) % 2).astype(np.float32) - 0.5
    return dirt(rng, grain(rng, toned(texture, 1 + 0.12 * weave), 0.06), 0.04)


def mesh_cloth(rng: Rng, size: Extent, color: int, pitch_m: float = 0.008) -> Texture:
    """A grille of small holes, as in front of loudspeakers and fans."""
    texture = grain(rng, flat(size, color), 0.03)
    h, w = texture.shape[:2]
    pitch = max(3, px(pitch_m))
    holes = (np.arange(h) % pitch < pitch * 0.55)[:, None] & (np.arange(w) % pitch < pitch * 0.55)[None, :]
    return toned(texture, 1 - 0.6 * holes)


def concrete(rng: Rng, size: Extent, color: int) -> Texture:
    """Cast concrete: blotches, fine grain, a few air holes."""
    texture = grain(rng, dirt(rng, flat(size, color), 0.05), 0.05)
    h, w = texture.shape[:2]
    for _ in range(int(60 * size[0] * size[1]) + 4):
        at = (int(rng.integers(w)), int(rng.integers(h)))
        cv2.circle(texture, at, int(rng.integers(1, 4)), bgr(lighter(color, 0.6)), -1, cv2.LINE_AA)
    return texture


def masonry(rng: Rng, size: Extent, color: int, joint: int, stone: Extent, bond: float = 0.5) -> Texture:
    """Bricks or tiles of the size `stone`, each in a shade of its own; every other row is shifted by `bond` stones."""
    texture = flat(size, joint)
    h, w = texture.shape[:2]
    step_x, step_y, gap = max(4, px(stone[0])), max(4, px(stone[1])), max(1, px(0.008))
    for row, y in enumerate(range(0, h, step_y)):
        for x in range(-round((row % 2) * bond * step_x), w, step_x):
            corner = (min(w, x + step_x - gap) - 1, min(h, y + step_y - gap) - 1)
            cv2.rectangle(texture, (max(0, x), y), corner, bgr(lighter(color, rng.uniform(0.82, 1.12))), -1)
    return dirt(rng, grain(rng, texture, 0.04), 0.05)


def marble(rng: Rng, size: Extent, color: int) -> Texture:
    """Polished stone with veins."""
    texture = flat(size, color)
    shape = (texture.shape[0], texture.shape[1])
    veins = np.exp(-8 * np.abs(clouds(rng, shape, 0.2 * PX_PER_M) + 0.3 * clouds(rng, shape, 0.04 * PX_PER_M)))
    return toned(texture, 1 + 0.06 * clouds(rng, shape, 0.15 * PX_PER_M) - 0.3 * veins)


def seamless(texture: Texture, border: float = 0.15) -> Texture:
    """The same without seams where it is repeated: borders, that share of a side wide, fade into its own middle."""
    smooth = texture.astype(np.float32)
    for axis in (0, 1):
        side = smooth.shape[axis]
        to_edge = np.minimum(np.arange(side) + 0.5, side - 0.5 - np.arange(side)) / side
        own = np.clip(to_edge / border, 0, 1).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1)).astype(np.float32)
        smooth = own * smooth + (1 - own) * np.roll(smooth, side // 2, axis)
    return np.asarray(smooth + 0.5, np.uint8)
