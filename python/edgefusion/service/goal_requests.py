# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Goals as they are asked for, as the mission knows them."""

from __future__ import annotations

import math
import uuid
from typing import List

from edgefusion.bus.requests import GoalRequest, GotoRequest
from edgefusion.errors import RefusedError
from edgefusion.types import Goal, Pose2D


def goals_of(request: GotoRequest, here: Pose2D | None) -> List[Goal]:
    """here: where the robot is now, in `odom`, for goals that are relative to it; None: it has not said so yet.

    Raises RefusedError for a goal that is none.
    """
    return [_goal(goal, here) for goal in request.goals]


def _goal(request: GoalRequest, here: Pose2D | None) -> Goal:
    pose = Pose2D(request.x_m, request.y_m, request.theta or 0.0)
    if request.frame == "base_link":
        if here is None:
            raise RefusedError("goal: expected a robot that has reported, got none yet: it is relative to it")
        pose = here.compose(pose)
    goal = Goal(request.id or uuid.uuid4().hex[:8], pose)
    position_m = request.position_tolerance_m or goal.position_tolerance_m
    heading = request.heading_tolerance or (math.pi if request.theta is None else goal.heading_tolerance)
    return Goal(goal.id, pose, position_m, heading)
