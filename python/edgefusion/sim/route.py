# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives a base along given points to a goal. It sees nothing: whoever made the route knows that it is free."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from edgefusion.sim.world import Point
from edgefusion.types import Pose2D, Twist2D

PASSED_M = 0.3
"""A point of the route that is so near counts as passed: the way is round at the corners."""


@dataclass(frozen=True)
class RouteLimits:
    """speed_mps, yaw_rate_radps: never exceeded. braking_mps2: on the way into the goal. place_m, direction: how near
    to the goal's pose is arrived."""

    speed_mps: float = 0.5
    yaw_rate_radps: float = 0.5
    braking_mps2: float = 0.2
    place_m: float = 0.02
    direction: float = math.radians(1.0)


class RouteFollower:
    """Answers poses with velocities: to each point of the route, to the goal, then turns as the goal asks for."""

    def __init__(self, route: Sequence[Point], goal: Pose2D, limits: RouteLimits | None = None) -> None:
        self._points = [*route, (goal.x_m, goal.y_m)]
        self._goal, self._limits = goal, limits or RouteLimits()
        self._there = False
        self.arrived = False

    def step(self, pose: Pose2D) -> Twist2D:
        """The velocity to drive with from here; the standstill once it has arrived."""
        while len(self._points) > 1 and _apart_m(pose, self._points[0]) < PASSED_M:
            self._points.pop(0)
        self._there = len(self._points) == 1 and self._at_goal(pose)
        return self._turn(pose) if self._there else self._drive(pose)

    def way_left_m(self, pose: Pose2D) -> float:
        """How far it still is, along the route."""
        way = [(pose.x_m, pose.y_m), *self._points]
        return sum(math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(way, way[1:]))

    def _at_goal(self, pose: Pose2D) -> bool:
        """Twice as far off is still there once it was, or it would never turn; farther, and it rolled past."""
        return self.arrived or _apart_m(pose, self._points[0]) < self._limits.place_m * (2 if self._there else 1)

    def _drive(self, pose: Pose2D) -> Twist2D:
        x_m, y_m = self._points[0]
        off = math.remainder(math.atan2(y_m - pose.y_m, x_m - pose.x_m) - pose.theta, 2 * math.pi)
        speed_mps = min(self._limits.speed_mps, math.sqrt(2 * self._limits.braking_mps2 * self.way_left_m(pose)))
        # The more it looks elsewhere the slower, and beyond 0.8 rad it turns on the spot: no circles about a point.
        return Twist2D(speed_mps * max(0.0, 1 - abs(off) / 0.8), self._yaw_rate(off))

    def _turn(self, pose: Pose2D) -> Twist2D:
        off = math.remainder(self._goal.theta - pose.theta, 2 * math.pi)
        self.arrived = self.arrived or abs(off) < self._limits.direction
        return Twist2D() if self.arrived else Twist2D(0.0, self._yaw_rate(off))

    def _yaw_rate(self, off: float) -> float:
        return max(-self._limits.yaw_rate_radps, min(self._limits.yaw_rate_radps, 1.5 * off))


def _apart_m(pose: Pose2D, point: Point) -> float:
    return math.hypot(point[0] - pose.x_m, point[1] - pose.y_m)
