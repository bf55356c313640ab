# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Velocities from Twist."""

from __future__ import annotations

from edgefusion.messages.cdr import WireError
from edgefusion.messages.geometry_msgs import Twist
from edgefusion.types import Twist2D


def to_cmd_vel(message: Twist) -> Twist2D:
    """A command. Raises WireError where it is not finite, or asks for what a robot on two wheels cannot do.

    Whether the robot may go so fast is the safety gate's question.
    """
    cannot = {
        "linear.y": message.linear.y,
        "linear.z": message.linear.z,
        "angular.x": message.angular.x,
        "angular.y": message.angular.y,
    }
    for name, value in cannot.items():
        if value != 0:
            raise WireError(f"cmd_vel: {name}: expected 0 of a robot on two wheels, got {value}")
    try:
        return Twist2D(message.linear.x, message.angular.z)
    except ValueError as error:
        raise WireError(f"cmd_vel: {error}") from None
