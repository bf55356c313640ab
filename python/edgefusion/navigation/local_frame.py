# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A frame in which the robot never jumps: what was seen stays where it is around the robot when its odometry jumps."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from edgefusion.config import BaseConfig
from edgefusion.types import STILL, Pose2D, Twist2D

Floats = npt.NDArray[np.float64]

# What odometry may differ by from what the base can do, before it counts as a jump.
_PLACE_M, _TURN = 0.08, math.radians(10)
_FASTER = 2.0
# After a pause nobody knows how far it went: a jump is carried on for so long at most.
_CARRIED_S = 0.5


class LocalFrame:
    """Equals `odom` until the odometry jumps."""

    def __init__(self, base: BaseConfig) -> None:
        self._base = base
        self._odom_in_local = STILL
        self._pose: Pose2D | None = None

    def enter(self, odometry: Pose2D, dt_s: float, twist: Twist2D) -> Pose2D:
        """The robot's pose in this frame, dt_s after the last one. twist: how fast it was since, as far as is known:
        across a jump it is carried on with that."""
        pose = self._odom_in_local.compose(odometry)
        if self._pose is not None and self._jumped(pose.relative_to(self._pose), dt_s):
            pose = self._pose.compose(twist.motion(min(dt_s, _CARRIED_S)))
            self._odom_in_local = pose.compose(STILL.relative_to(odometry))
        self._pose = pose
        return pose

    def place(self, in_odom: Pose2D) -> Pose2D:
        """A pose of `odom` in this frame."""
        return self._odom_in_local.compose(in_odom)

    def in_odom(self, points: Floats) -> Floats:
        """Points [n, 2] of this frame in `odom`."""
        x, y, theta = self._odom_in_local.x_m, self._odom_in_local.y_m, self._odom_in_local.theta
        c, s = math.cos(theta), math.sin(theta)
        return np.asarray((points - (x, y)) @ np.array([[c, -s], [s, c]]))

    def _jumped(self, motion: Pose2D, dt_s: float) -> bool:
        way_m = math.hypot(motion.x_m, motion.y_m)
        return (
            way_m > _FASTER * self._base.max_speed_mps * dt_s + _PLACE_M
            or abs(motion.theta) > _FASTER * self._base.max_yaw_rate_radps * dt_s + _TURN
        )
