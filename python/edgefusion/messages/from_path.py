# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Ways as Path."""

from __future__ import annotations

from typing import Sequence

from edgefusion.messages.frames import ODOM
from edgefusion.messages.geometry_msgs import PoseStamped
from edgefusion.messages.nav_msgs import Path
from edgefusion.messages.planar import pose_of
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Pose2D


def from_path(stamp_ns: int, poses: Sequence[Pose2D], stamper: Stamper, frame_id: str = ODOM) -> Path:
    """The poses on the way, in that frame, as of then."""
    header = stamper.header(stamp_ns, frame_id)
    return Path(header, [PoseStamped(header, pose_of(pose)) for pose in poses])
