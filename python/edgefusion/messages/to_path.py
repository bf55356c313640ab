# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Ways from Path."""

from __future__ import annotations

from edgefusion.messages.nav_msgs import Path
from edgefusion.messages.planar import planar
from edgefusion.types import Pose2D


def to_path(message: Path) -> list[Pose2D]:
    """The poses on the way, in the header's frame. Raises WireError for one that is none."""
    return [planar(each.pose, f"path: pose {index}") for index, each in enumerate(message.poses)]
