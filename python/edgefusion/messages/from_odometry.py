# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Odometry as nav_msgs has it."""

from __future__ import annotations

from edgefusion.messages.frames import BASE_LINK, ODOM
from edgefusion.messages.from_cmd_vel import from_cmd_vel
from edgefusion.messages.geometry_msgs import PoseWithCovariance, TwistWithCovariance
from edgefusion.messages.nav_msgs import Odometry
from edgefusion.messages.planar import pose_of
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Pose2D, Twist2D


def from_odometry(stamp_ns: int, pose: Pose2D, twist: Twist2D, stamper: Stamper) -> Odometry:
    """pose: in `odom`; twist: in base_link. How exact they are is not known: the covariances are zero."""
    return Odometry(
        stamper.header(stamp_ns, ODOM),
        BASE_LINK,
        PoseWithCovariance(pose_of(pose)),
        TwistWithCovariance(from_cmd_vel(twist)),
    )
