# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Simple worlds whose pictures and scans are known: flat panels and boxes before a robot at the origin."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.kinds.kind import Kind
from edgefusion.sim.mesh import plain, quad, standing_box
from edgefusion.sim.panda import open_pipe
from edgefusion.sim.rig import Rig
from edgefusion.sim.world import Thing, Wall, World
from edgefusion.types import Pose2D

LASER_HEIGHT_M = Rig().laser_height_m


def skip_without_renderer() -> None:
    """Skips a whole module where Panda3D, or a library that it needs, is missing, and says which."""
    try:
        open_pipe()
    except RefusedError as error:
        pytest.skip(str(error), allow_module_level=True)


def panel(x: float, y: float, width: float, low: float, high: float, color: int = 0xFFFFFF) -> Thing:
    """A flat panel that looks at the origin's side, its middle at (x, y), from a height to a height."""
    half = width / 2
    corners = [(0, -half, high), (0, half, high), (0, half, low), (0, -half, low)]
    kind = Kind("panel", "panel", (0.01, width, high), lambda rng: [quad(corners, plain(color))])
    return Thing(f"panel at {x:.3f}, {y:.3f}, {low:.3f}", kind, Pose2D(x, y, math.pi), 0)


def crate(name: str, x: float, y: float, size: tuple[float, float, float], theta: float = math.pi) -> Thing:
    """A closed box of that depth, width and height."""
    kind = Kind("box", f"label of {name}", size, lambda rng: standing_box(size, plain(0x909090)))
    return Thing(name, kind, Pose2D(x, y, theta), 0)


def built(things: Sequence[Thing], ceiling_m: float | None = None, walls: Sequence[Wall] = ()) -> BuiltWorld:
    """A world with these things, its plan at the height of the default rig's laser."""
    start = Pose2D()
    world = World("scene", 1, "asphalt", ceiling_m, tuple(walls), tuple(things), start, start)
    return build(world, LASER_HEIGHT_M)


def outline_points(thing: Thing, count: int = 41) -> np.ndarray:
    """Points [n, 3] along the edges of a panel, in the world."""
    (part,) = thing.placed(thing.kind.make(0))
    steps = np.linspace(0, 1, count)[:, None]
    return np.concatenate([a + steps * (b - a) for a, b in zip(part.vertices, np.roll(part.vertices, -1, axis=0))])
