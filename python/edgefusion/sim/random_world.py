# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds by seed: rooms and streets with objects that stand free, against a wall, or beside each other."""

from __future__ import annotations

import math
from typing import List, Sequence, Tuple

import cv2
import numpy as np

from edgefusion.sim.building import WALLS
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.world import Thing, Wall, World
from edgefusion.types import Pose2D

Rng = np.random.Generator
Rectangle = Tuple[Tuple[float, float], Tuple[float, float], float]
"""OpenCV's rotated rectangle: centre, (length along its axis, across), degrees."""

FREE_M = 0.75
"""Between a free-standing object and anything else: twice the default eps of DBSCAN, and a margin."""

WALL_M = 0.12
_TRIES = 60
_SIZE_SPREAD = 0.12
_INSIDE = ("linoleum", "carpet", "tiles", "parquet", "concrete")
_OUTSIDE = ("asphalt", "concrete")


def random_world(seed: int, kinds: Sequence[Kind], things: int = 9) -> World:
    """A world with up to so many objects of these kinds; the same seed gives the same world.

    The start is where no object is near, the goal is there, too: nobody drives there by itself.
    Objects keep apart by their rectangles, in whose middle their bodies are only about: in one world of twenty two of
    them, or one and a wall, stand in each other, by 34 mm at most in the first hundred.
    """
    rng = np.random.default_rng(seed)
    outside = bool(rng.random() < 0.25)
    depth, width = rng.uniform(5.0, 9.0, 2).tolist()
    finish = ("facade", "brick", "concrete") if outside else tuple(name for name in sorted(WALLS) if name != "facade")
    walls = _room(rng, depth, width, 5.5 if outside else float(rng.uniform(2.4, 3.2)), finish)
    placed = _Placed(rng, depth, width)
    for _ in range(things):
        placed.add(kinds[int(rng.integers(len(kinds)))])
    floor = str(rng.choice(np.asarray(_OUTSIDE if outside else _INSIDE)))
    ceiling_m = None if outside else walls[0].height_m
    return World(f"random-{seed}", seed, floor, ceiling_m, tuple(walls), tuple(placed.things), Pose2D(), Pose2D())


def _room(rng: Rng, depth: float, width: float, height_m: float, finishes: Sequence[str]) -> list[Wall]:
    """Four walls about the origin."""
    corners = [(-depth / 2, -width / 2), (depth / 2, -width / 2), (depth / 2, width / 2), (-depth / 2, width / 2)]
    finish = [str(each) for each in rng.choice(np.asarray(finishes), 4)]
    return [Wall(a, b, height_m, WALL_M, f) for a, b, f in zip(corners, corners[1:] + corners[:1], finish)]


class _Placed:
    """The objects so far, each where it stands in nothing else."""

    def __init__(self, rng: Rng, depth: float, width: float) -> None:
        self._rng, self._half = rng, (depth / 2 - WALL_M / 2, width / 2 - WALL_M / 2)
        self.things: List[Thing] = []
        self._sizes: List[Size] = []

    def add(self, kind: Kind) -> None:
        """One more object if there is room: free, with its back to a wall, or beside the last one."""
        rng = self._rng
        size = _size(rng, kind.size_m)
        draw = rng.random()
        for _ in range(_TRIES):
            if draw < 0.6 or (draw >= 0.8 and not self.things):
                pose, apart_m = self._free(), FREE_M
            elif draw < 0.8:
                pose, apart_m = self._against_wall(size), 0.0
            else:
                pose, apart_m = self._beside(self.things[-1], self._sizes[-1], size), 0.0
            if self._fits(pose, size, apart_m):
                name = f"{kind.name} {1 + sum(thing.kind is kind for thing in self.things)}"
                self.things.append(Thing(name, kind, pose, int(rng.integers(2**31)), size))
                self._sizes.append(size)
                return

    def _free(self) -> Pose2D:
        """Anywhere; its front mostly towards the middle of the room, where one looks at it from."""
        x, y = (float(self._rng.uniform(-half, half)) for half in self._half)
        towards = math.atan2(-y, -x) + float(self._rng.normal(0, 0.6))
        return Pose2D(x, y, towards if self._rng.random() < 0.7 else float(self._rng.uniform(-math.pi, math.pi)))

    def _against_wall(self, size: Size) -> Pose2D:
        side = int(self._rng.integers(4))
        theta = side * math.pi / 2  # looks away from the wall behind it
        gap_m = float(self._rng.uniform(0.0, 0.08)) + 0.02
        behind = (self._half[side % 2] - size[0] / 2 - gap_m) * -1
        along = float(self._rng.uniform(-1, 1)) * (self._half[1 - side % 2] - size[1] / 2)
        c, s = math.cos(theta), math.sin(theta)
        return Pose2D(c * behind - s * along, s * behind + c * along, theta)

    def _beside(self, other: Thing, other_size: Size, size: Size) -> Pose2D:
        """In a row with the other, its side to the other's."""
        sign = 1 if self._rng.random() < 0.5 else -1
        away = sign * ((other_size[1] + size[1]) / 2 + float(self._rng.uniform(0.01, 0.06)))
        forward = (other_size[0] - size[0]) / 2 + float(self._rng.normal(0, 0.06))
        c, s = math.cos(other.pose.theta), math.sin(other.pose.theta)
        x, y = other.pose.x_m + c * forward - s * away, other.pose.y_m + s * forward + c * away
        return Pose2D(x, y, other.pose.theta)

    def _fits(self, pose: Pose2D, size: Size, apart_m: float) -> bool:
        rectangle = _rectangle(pose, size, apart_m)
        corners = cv2.boxPoints(rectangle)
        if not (np.abs(corners) <= self._half).all():
            return False
        others = (_rectangle(thing.pose, s, 0.0) for thing, s in zip(self.things, self._sizes))
        return all(cv2.rotatedRectangleIntersection(rectangle, other)[0] == cv2.INTERSECT_NONE for other in others)


def _size(rng: Rng, usual: Size) -> Size:
    whole = rng.uniform(1 - _SIZE_SPREAD, 1 + _SIZE_SPREAD)
    depth, width, height = (np.asarray(usual) * whole * rng.uniform(0.95, 1.05, 3)).tolist()
    return depth, width, height


def _rectangle(pose: Pose2D, size: Size, apart_m: float) -> Rectangle:
    extent = (size[0] + 2 * apart_m, size[1] + 2 * apart_m)
    return (pose.x_m, pose.y_m), extent, math.degrees(pose.theta)
