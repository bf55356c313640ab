# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a world must be like to drive in: nothing inside anything else, and room where the robot starts and ends."""

from __future__ import annotations

from itertools import combinations
from typing import Iterable

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.sim.building import wall_parts
from edgefusion.sim.mesh import plain
from edgefusion.sim.outline import Outline, apart_m, outline_of
from edgefusion.sim.world import Point, World

ROBOT_RADIUS_M = 0.3
"""What a Pioneer 3-DX needs around its middle, with a margin of 3 cm."""

TOUCHING_M = 0.001
"""Things that stand against each other may be so far inside each other: files are written by hand."""


def check_world(world: World) -> None:
    """Raises RefusedError, one line with the names, for a world that cannot be."""
    _check_names(world)
    objects = {
        thing.name: outline_of(thing.placed(thing.kind.make(thing.seed, thing.size_m))) for thing in world.things
    }
    walls = [(f"the wall {_way(wall.start, wall.end)}", outline_of(wall_parts(wall, plain(0)))) for wall in world.walls]
    _check_apart(objects, walls)
    _check_ends(world, [*objects.items(), *walls])


def _check_names(world: World) -> None:
    names = [thing.name for thing in world.things]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise RefusedError(f"objects: expected every name once, got {', '.join(map(repr, twice))} twice or more")


def _check_apart(objects: dict[str, Outline], walls: list[tuple[str, Outline]]) -> None:
    pairs = [*combinations(objects.items(), 2), *((each, wall) for each in objects.items() for wall in walls)]
    for (name, outline), (other_name, other) in pairs:
        inside_m = -apart_m(outline, other)
        if inside_m > TOUCHING_M:
            raise RefusedError(
                f"objects: expected {name} and {other_name} apart, got {1000 * inside_m:.0f} mm of one inside the other"
            )


def _check_ends(world: World, obstacles: Iterable[tuple[str, Outline]]) -> None:
    """Start and goal. The way between them is the robot's to find, or to find that there is none."""
    for what, pose in (("start", world.start), ("goal", world.goal)):
        for name, outline in obstacles:
            free_m = apart_m(np.array([(pose.x_m, pose.y_m)]), outline)
            if free_m < ROBOT_RADIUS_M:
                raise RefusedError(
                    f"{what}: expected {ROBOT_RADIUS_M:g} m free on all sides, got {max(0.0, free_m):.2f} m to {name}"
                )


def _way(a: Point, b: Point) -> str:
    return f"from ({a[0]:g}, {a[1]:g}) to ({b[0]:g}, {b[1]:g})"
