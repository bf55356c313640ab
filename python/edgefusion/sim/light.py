# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a world is lit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np

Color = Tuple[float, float, float]


@dataclass(frozen=True)
class Light:
    """ambient, lamp: (r, g, b) factors. heading, pitch: where the lamp shines in the world [rad], pitch < 0 down."""

    ambient: Color = (0.55, 0.55, 0.55)
    lamp: Color = (0.5, 0.5, 0.48)
    heading: float = 0.6
    pitch: float = -0.9


def random_light(rng: np.random.Generator) -> Light:
    """From dim to bright, from bluish to yellowish, from any side above."""
    warmth = rng.normal(0, 0.05)
    tint = np.array([1 + warmth, 1.0, 1 - warmth])
    ambient, lamp = rng.uniform(0.38, 0.65) * tint, rng.uniform(0.25, 0.6) * tint
    return Light(_color(ambient), _color(lamp), float(rng.uniform(-np.pi, np.pi)), float(rng.uniform(-1.3, -0.5)))


def _color(factors: np.ndarray) -> Color:
    r, g, b = factors.tolist()
    return r, g, b
