# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Velocities as Twist."""

from __future__ import annotations

from edgefusion.messages.geometry_msgs import Twist, Vector3
from edgefusion.types import Twist2D


def from_cmd_vel(twist: Twist2D) -> Twist:
    """In base_link."""
    return Twist(Vector3(x=twist.v_mps), Vector3(z=twist.w_radps))
