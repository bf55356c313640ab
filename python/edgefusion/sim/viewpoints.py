# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where a robot may stand in a world to look at its objects, by chance."""

from __future__ import annotations

import math

import numpy as np

from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.floor_plan import distances_m
from edgefusion.types import Pose2D

Rng = np.random.Generator

ROOM_TO_STAND_M = 0.35
"""From where a robot stands to whatever is nearest: a little more than it needs to drive."""

NEAREST_M, FARTHEST_M = 0.5, 5.0
_TRIES = 200
_BEARING = 0.4


def viewpoint(world: BuiltWorld, rng: Rng) -> Pose2D | None:
    """A free pose that looks at one of the objects, from NEAREST_M to FARTHEST_M; None where none was found."""
    if not world.bodies or not len(world.plan.segments):
        return None
    for _ in range(_TRIES):
        index = int(rng.integers(len(world.bodies)))
        pose = _facing(world, index, rng)
        if _inside(world, pose) and distances_m([(pose.x_m, pose.y_m)], world.plan.segments).min() > ROOM_TO_STAND_M:
            return pose
    return None


def _facing(world: BuiltWorld, index: int, rng: Rng) -> Pose2D:
    """Somewhere around an object, mostly before its front, turned towards it."""
    thing = world.world.things[index]
    around = thing.pose.theta + float(rng.normal(0, 0.6) if rng.random() < 0.7 else rng.uniform(-math.pi, math.pi))
    away_m = float(rng.uniform(NEAREST_M, FARTHEST_M)) + max(world.sizes_m[index][:2]) / 2
    x, y = thing.pose.x_m + away_m * math.cos(around), thing.pose.y_m + away_m * math.sin(around)
    return Pose2D(x, y, around + math.pi + float(rng.uniform(-_BEARING, _BEARING)))


def _inside(world: BuiltWorld, pose: Pose2D) -> bool:
    """Within the box around all walls, or around everything where there are none."""
    walls = [p for wall in world.world.walls for p in (wall.start, wall.end)]
    ends = np.array(walls or world.plan.segments.reshape(-1, 2))
    return bool((ends.min(axis=0) <= (pose.x_m, pose.y_m)).all() and ((pose.x_m, pose.y_m) <= ends.max(axis=0)).all())
