# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where one frame is in another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.messages.frames import BASE_LINK, CAMERA_OPTICAL, LASER, ODOM
from edgefusion.types import Pose2D, read_only

Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class FrameTransform:
    """T_parent_child [4, 4] maps the child's coordinates into the parent's."""

    parent: str
    child: str
    T_parent_child: Matrix

    def __post_init__(self) -> None:
        T = np.asarray(self.T_parent_child, float)
        if T.shape != (4, 4) or not np.isfinite(T).all():
            raise ValueError(f"T_parent_child: expected finite numbers [4, 4], got {list(T.shape)}")
        object.__setattr__(self, "T_parent_child", read_only(T))


def robot_transform(pose: Pose2D) -> FrameTransform:
    """Where the robot is, in `odom`."""
    return FrameTransform(ODOM, BASE_LINK, pose.matrix())


def mounting(T_base_laser: Matrix, T_camera_laser: Matrix) -> list[FrameTransform]:
    """Where laser and camera are on the robot, from a calibration."""
    T_laser_camera: Matrix = np.linalg.inv(np.asarray(T_camera_laser, float)).astype(float)
    return [FrameTransform(BASE_LINK, LASER, T_base_laser), FrameTransform(LASER, CAMERA_OPTICAL, T_laser_camera)]
