# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds that are hard for a Pioneer 3-DX, by family and seed: the same seed gives the same world.

The robot turns about its axle within a circle of 0.37 m radius. Corridors and dead ends are at least GAP_M wide, and
so are the gaps between things; only doorways are narrower: DOORWAY_M, tighter still, or too narrow on purpose.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Dict, Tuple

import numpy as np
from benchmarks.maze_shapes import THICK_M, Floats, Point, Rng, box, clutter, disc, placed, room, wall, walls
from benchmarks.maze_world import WALK_MPS, MazeWorld, Person

from edgefusion.config.navigation import P3DX_FOOTPRINT_M
from edgefusion.navigation.progress import Reason
from edgefusion.types import Pose2D

ROBOT_WIDTH_M = 2 * P3DX_FOOTPRINT_M[0][1]
DOORWAY_M = ROBOT_WIDTH_M + 0.08
SPARE_M = 0.03, 0.07
"""What tight doorways are wider than the robot by."""

GAP_M = 0.95
PITCH_M = GAP_M + 2 * THICK_M
"""From one of a spiral's walls to the next."""

GOAL_TO_WALL_M = 0.4
JUMP_M = 0.3
SLIP_M = 0.01
NOMINAL_MPS = 0.5
"""What a person who is to meet the robot expects of it."""


def make(family: str, seed: int) -> MazeWorld:
    """The world of a family and a seed."""
    rng = np.random.default_rng([seed, list(FAMILIES).index(family)])
    return replace(FAMILIES[family](rng), family=family, seed=seed)


def doorway(rng: Rng) -> MazeWorld:
    """A wall across the room, not square to it, and a doorway that only the hull itself fits through."""
    return MazeWorld(_divided(rng, 9.0, 6.0, DOORWAY_M), _pose(rng, 1.3, 3.0, 1.2), _pose(rng, 7.7, 3.0, 1.2))


def u_trap(rng: Rng) -> MazeWorld:
    """A wide U between start and goal, open to the start."""
    depth_m, half_m = rng.uniform(1.3, 2.5), rng.uniform(1.3, 2.4) / 2
    trap = walls([(-depth_m, half_m), (0, half_m), (0, -half_m), (-depth_m, -half_m)])
    static = np.vstack([room(10.0, 8.0), placed(trap, (5.6, 4.0), rng.uniform(-0.35, 0.35))])
    return MazeWorld(static, _pose(rng, 1.2, 4.0, 0.4), _pose(rng, 8.7, 4.0, 0.4))


def spiral(rng: Rng) -> MazeWorld:
    """A spiral between start and goal, its mouth towards the start; every other robot starts at its inner end."""
    middle, inside = (5.5, 4.5), rng.random() < 0.5
    angle = math.pi / 2 + rng.uniform(-0.2, 0.2)
    static = np.vstack([room(11.0, 9.0), placed(_spiral(rng.random() < 0.5), middle, angle)])
    start = _pose(rng, *middle) if inside else _pose(rng, 1.2, 4.5, 0.5)
    return MazeWorld(static, start, _pose(rng, 9.7, 4.5, 0.5))


def near_wall(rng: Rng) -> MazeWorld:
    """A goal GOAL_TO_WALL_M from a wall, in any direction, in a room with things."""
    x_m, y_m = rng.uniform(3.5, 5.5), rng.uniform(1.5, 4.5)
    places = [(x_m, 6 - GOAL_TO_WALL_M), (x_m, GOAL_TO_WALL_M), (7 - GOAL_TO_WALL_M, y_m)]
    return _cluttered(rng, 7.0, 6.0, places[rng.integers(3)], 4, GAP_M)


def people(rng: Rng) -> MazeWorld:
    """Two people walk across the way, each about when the robot gets there."""
    start = Pose2D(1.2, 4.0, rng.uniform(-0.2, 0.2))
    both = tuple(_crossing(rng, start, (x_m, 4.0)) for x_m in (4.0 + rng.uniform(-0.5, 0.5), rng.uniform(7.5, 8.5)))
    return MazeWorld(room(12.0, 8.0), start, _pose(rng, 10.8, 4.0), people=both)


def slip(rng: Rng) -> MazeWorld:
    """Things in a room, and wheels that slip."""
    return replace(_cluttered(rng, 9.0, 7.0, (7.7, 3.5), 7, GAP_M), slip_m=SLIP_M)


def jump(rng: Rng) -> MazeWorld:
    """Things in a room, and odometry that jumps on the way."""
    world = _cluttered(rng, 9.0, 7.0, (7.5, 3.5), 5, GAP_M + JUMP_M)
    way = rng.uniform(-math.pi, math.pi)
    by = Pose2D(JUMP_M * math.cos(way), JUMP_M * math.sin(way), 0.0)
    return replace(world, jump_s=rng.uniform(4.0, 10.0), jump=by)


def slow_scans(rng: Rng) -> MazeWorld:
    """Things in a room, and scans that come late and seldom."""
    return replace(_cluttered(rng, 9.0, 7.0, (7.7, 3.5), 7, GAP_M), slow_scans=True)


def enclosed(rng: Rng) -> MazeWorld:
    """A goal within four walls of its own."""
    side_m, angle = rng.uniform(1.3, 1.8), rng.uniform(0, math.pi)
    cell = [box((4.4, 3.0), side, side, angle) for side in (side_m, side_m - 2 * THICK_M)]
    return MazeWorld(
        np.vstack([room(7.0, 6.0), *cell]), _pose(rng, 1.2, 3.0, 1.5), _pose(rng, 4.4, 3.0), reasons=(Reason.ENCLOSED,)
    )


def occupied(rng: Rng) -> MazeWorld:
    """A goal inside a pillar, inside a box, or in a wall."""
    goal, size_m = _pose(rng, 5.0, 3.0, 1.0), rng.uniform(0.15, 0.2)
    at, angle = (goal.x_m, goal.y_m), rng.uniform(0, math.pi)
    things = [disc(at, size_m), box(at, 2 * size_m, 2 * size_m, angle), np.zeros((0, 4))]
    kind = int(rng.integers(3))
    if kind == 2:
        goal = replace(goal, x_m=7.0 - rng.uniform(0.0, 0.1))
    static = np.vstack([room(7.0, 6.0), things[kind]])
    return MazeWorld(static, _pose(rng, 1.2, 3.0, 1.5), goal, reasons=(Reason.OCCUPIED,))


def narrow(rng: Rng) -> MazeWorld:
    """A wall across the room with a doorway narrower than the robot."""
    static = _divided(rng, 7.0, 5.0, float(rng.uniform(0.7, 0.9)) * ROBOT_WIDTH_M)
    return MazeWorld(static, _pose(rng, 1.1, 2.5, 0.8), _pose(rng, 5.9, 2.5, 0.8), reasons=(Reason.ENCLOSED,))


def tight_doorway(rng: Rng) -> MazeWorld:
    """As `doorway`, but with less room than the navigator is made for: how narrow they may be is what it shows."""
    static = _divided(rng, 9.0, 6.0, ROBOT_WIDTH_M + rng.uniform(*SPARE_M))
    return MazeWorld(static, _pose(rng, 1.3, 3.0, 1.2), _pose(rng, 7.7, 3.0, 1.2), demanded=False)


FAMILIES: Dict[str, Callable[[Rng], MazeWorld]] = {
    make_one.__name__: make_one
    for make_one in (
        doorway, u_trap, spiral, near_wall, people, slip, jump, slow_scans, enclosed, occupied, narrow, tight_doorway
    )
}  # fmt: skip


def _pose(rng: Rng, x_m: float, y_m: float, aside_m: float = 0.0) -> Pose2D:
    """In any direction, up to so far aside in y."""
    return Pose2D(x_m, y_m + rng.uniform(-aside_m, aside_m), rng.uniform(-math.pi, math.pi))


def _divided(rng: Rng, width_m: float, height_m: float, doorway_m: float) -> Floats:
    """A room with a slanted wall from top to bottom that has a doorway about its middle."""
    slant = rng.uniform(0.15, 0.7) * rng.choice((-1, 1))
    along = np.array([math.sin(slant), math.cos(slant)])
    middle = np.array([width_m / 2 + rng.uniform(-0.4, 0.4), height_m / 2])
    aside_m, half_m = rng.uniform(-1.0, 1.0), doorway_m / 2
    end_m = (height_m / 2 + THICK_M) / along[1]  # ends beyond the room's walls
    ends = [tuple(middle + along * s) for s in (-end_m, aside_m - half_m, aside_m + half_m, end_m)]
    return np.vstack([room(width_m, height_m), wall(ends[0], ends[1]), wall(ends[2], ends[3])])


def _spiral(mirrored: bool) -> Floats:
    """Walls about the origin, where the dead end is; the mouth is at +y."""
    corners = np.array([(0, 0), (1, 0), (1, 1), (-1, 1), (-1, -1), (2, -1), (2, 2)]) - 0.5
    around = corners * PITCH_M * ((-1, 1) if mirrored else (1, 1))
    return walls([(x, y) for x, y in around.tolist()])


def _cluttered(rng: Rng, width_m: float, height_m: float, goal: Point, count: int, gap_m: float) -> MazeWorld:
    start, end = _pose(rng, 1.3, height_m / 2, 1.0), _pose(rng, *goal)
    free = [(start.x_m, start.y_m), (end.x_m, end.y_m)]
    return MazeWorld(
        np.vstack([room(width_m, height_m), clutter(rng, width_m, height_m, count, gap_m, free)]), start, end
    )


def _crossing(rng: Rng, start: Pose2D, at: Point) -> Person:
    """Walks over a point of the way, up to 1.5 s before or after the robot may be there."""
    way_m, side = 3.2, rng.choice((-1, 1))
    slant = rng.uniform(-0.35, 0.35)
    step = (way_m * math.sin(slant), way_m * math.cos(slant) * side)
    there_s = (at[0] - start.x_m) / NOMINAL_MPS + 1.0 + rng.uniform(-1.5, 1.5)
    ends: Tuple[Point, Point] = ((at[0] - step[0], at[1] - step[1]), (at[0] + step[0], at[1] + step[1]))
    return Person(*ends, there_s - way_m / WALK_MPS)
