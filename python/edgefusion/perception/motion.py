# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The robot's motion between a scan and a frame, and what it does to a point in the image."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from edgefusion._core import project
from edgefusion.perception.calibration import Calibration
from edgefusion.types import STILL, Pose2D

Matrix = npt.NDArray[np.float64]


def transform(T: Matrix, point: Matrix) -> Matrix:
    """A point [3] in another frame, T [4, 4]."""
    return T[:3, :3] @ point + T[:3, 3]


def laser_motion(motion: Pose2D, T_base_laser: Matrix) -> Matrix:
    """Maps laser coordinates at the scan's stamp into laser coordinates at the frame's stamp, [4, 4].

    motion: the robot's pose at the frame's stamp in its base_link at the scan's.
    """
    if motion == STILL:
        return np.eye(4)  # the common case, and two inversions are a tenth of a millisecond
    return np.linalg.inv(T_base_laser) @ np.linalg.inv(motion.matrix()) @ T_base_laser


def shift_px(point: Matrix, moved: Matrix, calibration: Calibration) -> float:
    """How far apart two laser points [3] are in the image [px]; NaN where the camera sees only one of them."""
    pixels, _ = project(np.stack([point, moved]), calibration.camera, calibration.T_camera_laser)
    return float(np.hypot(*(pixels[1] - pixels[0])))
