# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The navigation function as a field: computed anew all the time, in portions, from the newest map."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from edgefusion._core import NavigationFunction
from edgefusion.config import NavigationConfig
from edgefusion.navigation.field import NOWHERE, Descent
from edgefusion.navigation.progress import Reason
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Pose2D

PORTION = 60_000
"""Cells' work a step: a few milliseconds. A hall of 60 x 60 m takes one to two seconds."""

GAP_CLOSED_M = 0.02
"""Points are not exact: ways so much narrower than the inscribed circle stay open, and the guard decides."""

_LOOK_AHEAD_M, _LOOK_AHEAD_S = 0.15, 0.35
_SHUT = {"occupied": Reason.OCCUPIED, "enclosed": Reason.ENCLOSED}


class FunctionField:
    """function: the potential in use.

    It looks a little way down that, farther at speed, so that it does not follow every cell's corner.
    """

    def __init__(self, navigation: NavigationConfig, inscribed_m: float) -> None:
        self._blocked_m = inscribed_m - GAP_CLOSED_M
        self.function = NavigationFunction(
            self._blocked_m, inscribed_m + navigation.comfort_m, navigation.comfort_weight
        )
        self._computed = False
        self._goal_m = 0.0, 0.0

    @property
    def shut(self) -> Reason | None:
        return _SHUT.get(self.function.outcome) if self._computed else None

    def update(self, surroundings: Surroundings, goal: Pose2D, tolerance_m: float, pose: Pose2D) -> None:
        function, map_ = self.function, surroundings.map
        self._goal_m = goal.x_m, goal.y_m
        if not function.running:
            function.begin(map_, goal.x_m, goal.y_m, tolerance_m, pose.x_m, pose.y_m)
        self._computed = function.advance(map_, PORTION) or self._computed

    def way(self, pose: Pose2D, length_m: float) -> npt.NDArray[np.float64]:
        """The way ahead [k, 2], in the local frame."""
        return self.function.way(pose.x_m, pose.y_m, length_m, self._blocked_m)

    def left_m(self, pose: Pose2D) -> float:
        """To the goal as the function counts it, longer near obstacles; inf where there is no way."""
        way = self.way(pose, 0.0)
        return self.function.value(*way[0]) if len(way) else math.inf

    def descend(self, pose: Pose2D, speed_mps: float) -> Descent:
        way = self.way(pose, _LOOK_AHEAD_M + _LOOK_AHEAD_S * speed_mps)
        if not len(way):
            return NOWHERE
        dx, dy = way[-1] - (pose.x_m, pose.y_m)
        left_m = self.function.value(*way[0])
        return Descent(math.atan2(dy, dx), 1.0, left_m, self._way_left_m(pose, left_m))

    def _way_left_m(self, pose: Pose2D, left_m: float) -> float:
        """Along the way; from where the map ends as the crow flies. Counted by the function it is never shorter."""
        points = np.vstack([(pose.x_m, pose.y_m), self.way(pose, left_m), self._goal_m])
        return float(np.hypot(*np.diff(points, axis=0).T).sum())
