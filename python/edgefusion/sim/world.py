# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a world is: walls, and objects placed by name. Frame: x, y on the ground, z up; metres, radians."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Tuple

from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, placed
from edgefusion.types import Pose2D

Point = Tuple[float, float]


@dataclass(frozen=True)
class Wall:
    """A straight wall from start to end; finish: how it looks, one of building.WALLS."""

    start: Point
    end: Point
    height_m: float
    thickness_m: float
    finish: str


@dataclass(frozen=True)
class Thing:
    """An object that stands in the world. pose: its middle on the ground and where its front looks."""

    name: str
    kind: Kind
    pose: Pose2D
    seed: int
    size_m: Size | None = None

    def placed(self, parts: Iterable[Part]) -> list[Part]:
        """Surfaces in the object's own frame, in the world's."""
        return placed(parts, (self.pose.x_m, self.pose.y_m, 0), self.pose.theta)


@dataclass(frozen=True)
class World:
    """A place to drive in.

    floor: one of building.FLOORS. ceiling_m: its height, None under the sky. start, goal: of the robot.
    description: one line about it.
    """

    name: str
    seed: int
    floor: str
    ceiling_m: float | None
    walls: tuple[Wall, ...]
    things: tuple[Thing, ...]
    start: Pose2D
    goal: Pose2D
    description: str = ""
