# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Goals from PoseStamped, whoever sent it."""

from __future__ import annotations

import math
from typing import NamedTuple

from edgefusion.messages.cdr import WireError
from edgefusion.messages.frames import BASE_LINK, ODOM
from edgefusion.messages.geometry_msgs import PoseStamped
from edgefusion.messages.planar import planar
from edgefusion.types import Pose2D

FARTHEST_M = 1000.0
"""Odometry leads nowhere beyond."""
_NAME = "goal_pose"


class GoalPose(NamedTuple):
    """frame_id: ODOM or BASE_LINK."""

    frame_id: str
    pose: Pose2D

    def in_odom(self, robot: Pose2D) -> Pose2D:
        """robot: its pose in `odom` when the goal came."""
        return robot.compose(self.pose) if self.frame_id == BASE_LINK else self.pose


def to_goal_pose(message: PoseStamped) -> GoalPose:
    """Raises WireError for another frame, and for a pose that is none or too far away.

    Its stamp is not looked at: it may be of any clock.
    """
    frame_id = message.header.frame_id
    if frame_id not in (ODOM, BASE_LINK):
        raise WireError(f"{_NAME}: expected the frame {ODOM} or {BASE_LINK}, got {frame_id!r}")
    pose = planar(message.pose, _NAME)
    if math.hypot(pose.x_m, pose.y_m) > FARTHEST_M:
        raise WireError(f"{_NAME}: expected at most {FARTHEST_M:g} m away, got ({pose.x_m:g}, {pose.y_m:g})")
    return GoalPose(frame_id, pose)
