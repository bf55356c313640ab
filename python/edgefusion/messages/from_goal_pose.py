# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Goals as PoseStamped, as RViz's goal tool sends them."""

from __future__ import annotations

from edgefusion.messages.frames import ODOM
from edgefusion.messages.geometry_msgs import PoseStamped
from edgefusion.messages.planar import pose_of
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Pose2D


def from_goal_pose(stamp_ns: int, pose: Pose2D, stamper: Stamper, frame_id: str = ODOM) -> PoseStamped:
    """pose: in that frame, `odom` or `base_link`."""
    return PoseStamped(stamper.header(stamp_ns, frame_id), pose_of(pose))
