# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What drives the robot: a potential, asked for the way down it. There are two (khatib_field, function_field)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from edgefusion.navigation.progress import Reason
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Pose2D


@dataclass(frozen=True)
class Descent:
    """direction: of -grad U, in the local frame [rad]; None where there is none. pull: how strong, 1 for as fast as
    it may. left_m: to the goal as the field counts it, where a metre near obstacles may be several; way_left_m: in
    plain metres; both inf where no way is known."""

    direction: float | None
    pull: float
    left_m: float
    way_left_m: float


NOWHERE = Descent(None, 0.0, math.inf, math.inf)


class Field(Protocol):
    """One goal's potential over what is seen."""

    def update(self, surroundings: Surroundings, goal: Pose2D, tolerance_m: float, pose: Pose2D) -> None:
        """Once a step, before anything is asked."""

    def descend(self, pose: Pose2D, speed_mps: float) -> Descent:
        """The way down for a robot there that is so fast."""

    def way(self, pose: Pose2D, length_m: float) -> npt.NDArray[np.float64]:
        """The way ahead [k, 2], in the local frame; empty where there is none, or none is planned."""

    @property
    def shut(self) -> Reason | None:
        """Why there is no way, as far as is known now."""
