# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Odometry from what nav_msgs has."""

from __future__ import annotations

import math
from typing import NamedTuple

from edgefusion.messages.cdr import WireError
from edgefusion.messages.nav_msgs import Odometry
from edgefusion.messages.planar import planar
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Pose2D, Twist2D


class Reckoning(NamedTuple):
    """pose: in the frame of the odometry; twist: in base_link."""

    stamp_ns: int
    pose: Pose2D
    twist: Twist2D


def to_odometry(message: Odometry, stamper: Stamper) -> Reckoning:
    """Raises WireError for a pose or a velocity that is none."""
    twist = message.twist.twist
    velocity = twist.linear.x, twist.angular.z
    if not all(map(math.isfinite, velocity)):
        raise WireError(f"odometry: expected a finite velocity, got {velocity}")
    pose = planar(message.pose.pose, "odometry")
    return Reckoning(stamper.to_ns(message.header.stamp), pose, Twist2D(*velocity))
