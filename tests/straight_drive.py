# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives a base straight to a pose. It sees nothing: whoever uses it knows that the way is free."""

from __future__ import annotations

import math

from edgefusion.types import Goal, Pose2D, Twist2D

SPEED_MPS, YAW_RATE_RADPS, BRAKING_MPS2 = 0.5, 0.5, 0.2


class StraightDrive:
    """Answers poses with velocities: to the goal, then turns as it asks for."""

    def __init__(self, goal: Goal) -> None:
        self._goal, self._there = goal, False
        self.arrived = False

    def way_left_m(self, pose: Pose2D) -> float:
        return math.hypot(self._goal.pose.x_m - pose.x_m, self._goal.pose.y_m - pose.y_m)

    def step(self, pose: Pose2D) -> Twist2D:
        """The velocity to drive with from here; the standstill once it has arrived."""
        # Twice as far off is still there once it was, or it would never turn.
        reach_m = self._goal.position_tolerance_m * (2 if self._there else 1)
        self._there = self.arrived or self.way_left_m(pose) < reach_m
        return self._turn(pose) if self._there else self._drive(pose)

    def _drive(self, pose: Pose2D) -> Twist2D:
        to = self._goal.pose
        off = math.remainder(math.atan2(to.y_m - pose.y_m, to.x_m - pose.x_m) - pose.theta, 2 * math.pi)
        speed_mps = min(SPEED_MPS, math.sqrt(2 * BRAKING_MPS2 * self.way_left_m(pose)))
        # The more it looks elsewhere the slower, and beyond 0.8 rad it turns on the spot: no circles about a point.
        return Twist2D(speed_mps * max(0.0, 1 - abs(off) / 0.8), _yaw_rate(off))

    def _turn(self, pose: Pose2D) -> Twist2D:
        off = math.remainder(self._goal.pose.theta - pose.theta, 2 * math.pi)
        self.arrived = self.arrived or abs(off) < self._goal.heading_tolerance
        return Twist2D() if self.arrived else Twist2D(0.0, _yaw_rate(off))


def _yaw_rate(off: float) -> float:
    return max(-YAW_RATE_RADPS, min(YAW_RATE_RADPS, 1.5 * off))
