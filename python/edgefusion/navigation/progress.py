# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How far a navigator has got with its goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class State(str, Enum):
    """DRIVING includes standing while the way is shut for the moment; TURNING: there, and turning as the goal asks."""

    DRIVING = "driving"
    TURNING = "turning"
    ARRIVED = "arrived"
    BLOCKED = "blocked"


class Reason(str, Enum):
    """Why a goal cannot be reached: BLOCKED ends the goal."""

    ENCLOSED = "goal enclosed"
    OCCUPIED = "goal inside an obstacle"
    NO_PROGRESS = "no progress"


@dataclass(frozen=True)
class Progress:
    """goal_id: whose progress it is. reason: of BLOCKED. way_left_m: along the way that is known, as the crow flies
    from where the map ends, and by a field that plans no way; inf where there is none.

    clearance_m: between the hull and the nearest thing that the laser has seen. note: what limits the robot now, in
    words, empty when nothing does.
    """

    goal_id: str
    state: State
    way_left_m: float
    clearance_m: float = math.inf
    reason: Reason | None = None
    note: str = ""
