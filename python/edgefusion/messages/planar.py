# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Poses in the plane, in which the robot drives, as the poses of ROS, which are in space."""

from __future__ import annotations

import math

from edgefusion.messages.cdr import WireError
from edgefusion.messages.geometry_msgs import Point, Pose, Quaternion
from edgefusion.messages.rotations import rotation_of
from edgefusion.types import Pose2D

MOST_TILT = math.radians(20)
"""A ramp, or the noise of an IMU; what leans more is no pose in the plane."""


def pose_of(pose: Pose2D) -> Pose:
    """On the ground."""
    half = math.remainder(pose.theta, 2 * math.pi) / 2
    return Pose(Point(pose.x_m, pose.y_m, 0.0), Quaternion(0.0, 0.0, math.sin(half), math.cos(half)))


def planar(pose: Pose, name: str) -> Pose2D:
    """Seen from above. Raises WireError, naming what it is of, for what is no number, no rotation or not level."""
    place = pose.position.x, pose.position.y, pose.position.z
    if not all(map(math.isfinite, place)):
        raise WireError(f"{name}: expected a place in finite metres, got {place}")
    R = rotation_of(pose.orientation, name)
    if R[2, 2] < math.cos(MOST_TILT):
        raise WireError(f"{name}: expected it level, got it tilted by {math.degrees(math.acos(R[2, 2])):.0f} degrees")
    return Pose2D(pose.position.x, pose.position.y, math.atan2(R[1, 0], R[0, 0]))
