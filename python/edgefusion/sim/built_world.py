# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A world with its surfaces made, which laser, camera and truth share: making them takes a tenth of a second."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from edgefusion.sim.building import building_parts
from edgefusion.sim.floor_plan import FloorPlan, floor_plan
from edgefusion.sim.kinds.kind import Size
from edgefusion.sim.mesh import Part, size_of
from edgefusion.sim.world import Thing, World

Parts = Tuple[Part, ...]


@dataclass(frozen=True)
class BuiltWorld:
    """building, bodies: surfaces in the world's frame, one body per thing. plan: what the laser meets."""

    world: World
    building: Parts
    bodies: tuple[Parts, ...]
    sizes_m: tuple[Size, ...]
    plan: FloorPlan

    def size_m(self, thing: Thing) -> Size:
        """(depth, width, height) of one of the world's things."""
        return self.sizes_m[self.world.things.index(thing)]


def build(world: World, laser_height_m: float) -> BuiltWorld:
    """Makes all surfaces, and the plan at the laser's height."""
    own = [thing.kind.make(thing.seed, thing.size_m) for thing in world.things]
    sizes = [size_of(parts).tolist() for parts in own]
    bodies = [thing.placed(parts) for thing, parts in zip(world.things, own)]
    building = building_parts(world)
    return BuiltWorld(
        world,
        tuple(building),
        tuple(tuple(body) for body in bodies),
        tuple((depth, width, height) for depth, width, height in sizes),
        floor_plan(building, bodies, laser_height_m),
    )
