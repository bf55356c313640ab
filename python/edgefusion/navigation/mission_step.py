# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a step of the mission answers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from edgefusion.navigation.inspection_result import InspectionResult, PictureRequest
from edgefusion.navigation.progress import Progress
from edgefusion.types import Goal, Twist2D


class MissionState(str, Enum):
    """STOPPED is left by `resume` alone."""

    IDLE = "idle"
    DRIVING = "driving"
    INSPECTING = "inspecting"
    ARRIVED = "arrived"
    BLOCKED = "blocked"
    STOPPED = "stopped"


@dataclass(frozen=True)
class MissionStep:
    """What to do now, and what happened.

    reason: of BLOCKED and STOPPED. goal: that is driven to, or will be next, as its operator gave it; None without one.
    progress: the navigator's, while it drives or turns the robot. request, result: in one step each, when it is asked
    for and when it is there. note: what the robot is doing, in words.
    """

    twist: Twist2D
    state: MissionState
    reason: str = ""
    goal: Goal | None = None
    progress: Progress | None = None
    request: PictureRequest | None = None
    result: InspectionResult | None = None
    note: str = ""

    @property
    def goal_id(self) -> str:
        """Of the goal; "" without one."""
        return "" if self.goal is None else self.goal.id
