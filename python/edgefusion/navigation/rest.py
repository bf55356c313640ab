# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a robot is at rest, by its odometry."""

from __future__ import annotations

import math

from edgefusion.errors import RefusedError
from edgefusion.pose_history import PoseHistory
from edgefusion.types import Pose2D

REST_NS, REST_M, REST_TURN = 200_000_000, 0.002, math.radians(0.3)
"""Moved by no more than this in so long. A P3-DX counts in whole millimetres."""


def is_at_rest(stamp_ns: int, pose: Pose2D, poses: PoseHistory) -> bool:
    """poses: those until stamp_ns, where the robot is at `pose`. Without poses for long enough it is not."""
    try:
        moved = pose.relative_to(poses.at(stamp_ns - REST_NS))
    except RefusedError:
        return False
    return math.hypot(moved.x_m, moved.y_m) <= REST_M and abs(moved.theta) <= REST_TURN
