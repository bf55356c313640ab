# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A world for a drive: what stands, who walks, what is wrong with the robot, and what should come of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
from benchmarks.maze_shapes import Floats, Point, disc

from edgefusion.navigation.progress import Reason
from edgefusion.types import STILL, Pose2D

PERSON_RADIUS_M = 0.25
WALK_MPS = 1.0

_NS_PER_S = 1e9


@dataclass(frozen=True)
class Person:
    """Walks straight from one point to another, from a time on; stands before and after that. Looks at nothing."""

    start: Point
    end: Point
    leaves_s: float

    def at(self, stamp_ns: int) -> Point:
        """Where he is at a time."""
        way_m = math.dist(self.start, self.end)
        share = min(max(WALK_MPS * (stamp_ns / _NS_PER_S - self.leaves_s) / way_m, 0.0), 1.0)
        return (
            self.start[0] + share * (self.end[0] - self.start[0]),
            self.start[1] + share * (self.end[1] - self.start[1]),
        )


@dataclass(frozen=True)
class MazeWorld:
    """static: what never moves, float64[m, 4]. reasons: of which a goal out of reach may end; none: it can be reached.
    demanded: whether it has to be, or how a drive ends only shows how far it goes, as long as nothing is touched.
    jump: of the odometry, at jump_s; slip_m: BaseSpec's; slow_scans: those of a line of 38400 baud."""

    static: Floats
    start: Pose2D
    goal: Pose2D
    family: str = ""
    seed: int = 0
    people: Tuple[Person, ...] = ()
    reasons: Tuple[Reason, ...] = ()
    demanded: bool = True
    slip_m: float = 0.0
    jump_s: float = 0.0
    jump: Pose2D = STILL
    slow_scans: bool = False

    @property
    def name(self) -> str:
        return f"{self.family}-{self.seed}"

    def segments_at(self, stamp_ns: int) -> Floats:
        """All that is there at a time, float64[m, 4]; the same array every time where nobody walks."""
        if not self.people:
            return self.static
        return np.vstack([self.static, *(disc(person.at(stamp_ns), PERSON_RADIUS_M) for person in self.people)])
