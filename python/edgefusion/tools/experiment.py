# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's experiment: a goal across the laboratory, an oscilloscope at a place that the robot does not know."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.sim.building import wall_parts
from edgefusion.sim.mesh import plain
from edgefusion.sim.outline import Outline, apart_m, outline_of
from edgefusion.sim.world import Point, Thing, World
from edgefusion.types import Pose2D

LABORATORY, ON_THE_WAY = "laboratory", "oscilloscope on the way"

ROOM_M = 0.9
"""Left free all around the object: a Pioneer 3-DX, which sweeps 0.74 m when it turns on the spot, gets around it, so
that no goal that was within reach is out of it."""

ALONG, ASIDE_M, TURNED = (0.3, 0.75), 0.5, math.radians(30)
"""Where on the straight way it stands, at most how far beside it, and how far it looks away from the start."""

_TRIES = 200


def placed_by_seed(world: World, seed: int) -> World:
    """The world with its oscilloscope near the straight way to the goal; seed 0 leaves it where it is.

    Raises RefusedError where there is no such thing in the world, or no room for it.
    """
    thing = next((each for each in world.things if each.name == ON_THE_WAY), None)
    if thing is None:
        raise RefusedError(f"world {world.name!r}: expected an object named {ON_THE_WAY!r}, got none")
    if seed == 0:
        return world
    rng, others = np.random.default_rng([seed, world.seed]), _others(world, thing)
    outline = outline_of(thing.kind.make(thing.seed, thing.size_m))
    for _ in range(_TRIES):
        moved = replace(thing, pose=_drawn(world, rng))
        there = np.array([_corner(moved.pose, *corner) for corner in outline])
        if all(apart_m(there, other) >= ROOM_M for other in others):
            return replace(world, things=tuple(moved if each is thing else each for each in world.things))
    raise RefusedError(f"world {world.name!r}: no room for {ON_THE_WAY!r} near the way to its goal")


def _drawn(world: World, rng: np.random.Generator) -> Pose2D:
    """A pose near the straight way, that looks back along it."""
    start, goal = world.start, world.goal
    way = math.atan2(goal.y_m - start.y_m, goal.x_m - start.x_m)
    along_m = rng.uniform(*ALONG) * math.hypot(goal.x_m - start.x_m, goal.y_m - start.y_m)
    line = Pose2D(start.x_m, start.y_m, way)
    return line.compose(Pose2D(along_m, rng.uniform(-ASIDE_M, ASIDE_M), math.pi + rng.uniform(-TURNED, TURNED)))


def _corner(pose: Pose2D, x_m: float, y_m: float) -> Point:
    """A point of the object's own frame, in the world."""
    corner = pose.compose(Pose2D(x_m, y_m))
    return corner.x_m, corner.y_m


def _others(world: World, thing: Thing) -> list[Outline]:
    """All that must not be near it: things, walls, start and goal."""
    things = [outline_of(each.placed(each.kind.make(each.seed, each.size_m))) for each in world.things if each != thing]
    walls = [outline_of(wall_parts(wall, plain(0))) for wall in world.walls]
    return [*things, *walls, *(np.array([(pose.x_m, pose.y_m)]) for pose in (world.start, world.goal))]
