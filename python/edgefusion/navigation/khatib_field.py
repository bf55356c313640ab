# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's potential as a field: what the newest scan shows repels, nothing is remembered."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from edgefusion.config import NavigationConfig
from edgefusion.navigation import khatib
from edgefusion.navigation.field import NOWHERE, Descent
from edgefusion.navigation.progress import Reason
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Pose2D

Floats = npt.NDArray[np.float64]


class KhatibField:
    """It has local minima, and does not know when it is in one: there is never a reason of its own to give up."""

    shut: Reason | None = None

    def __init__(self, navigation: NavigationConfig, max_speed_mps: float) -> None:
        self._config, self._max_speed_mps = navigation.khatib, max_speed_mps
        self._near = False
        self._points: Floats = np.zeros((0, 2))
        self._goal = Pose2D()

    def update(self, surroundings: Surroundings, goal: Pose2D, tolerance_m: float, pose: Pose2D) -> None:
        self._points, self._goal = surroundings.points, goal

    def descend(self, pose: Pose2D, speed_mps: float) -> Descent:
        goal = np.array([self._goal.x_m, self._goal.y_m])
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        to_base = np.array([[c, -s], [s, c]])
        here = np.array([pose.x_m, pose.y_m])
        (ux, uy), self._near = khatib.descend(
            (goal - here) @ to_base, (self._points - here) @ to_base, self._near, self._config
        )
        strength = math.hypot(ux, uy)
        left_m = float(np.hypot(*(goal - here)))
        if strength == 0:
            return NOWHERE
        return Descent(pose.theta + math.atan2(uy, ux), min(1.0, strength / self._max_speed_mps), left_m, left_m)

    def way(self, pose: Pose2D, length_m: float) -> Floats:
        """It plans none."""
        return np.zeros((0, 2))
