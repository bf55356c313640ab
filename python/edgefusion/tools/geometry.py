# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Small geometry that several tools share."""

from __future__ import annotations

from edgefusion.perception.calibration import Calibration
from edgefusion.sim.rig import Rig
from edgefusion.types import Box


def calibration_of(rig: Rig) -> Calibration:
    """What a perfect calibration of a simulated rig says."""
    return Calibration(
        image_size=rig.image_size,
        K=rig.K,
        distortion=rig.distortion,
        T_camera_laser=rig.T_camera_laser,
        T_base_laser=rig.T_base_laser,
        laser_height_m=rig.laser_height_m,
    )


def iou(a: Box, b: Box) -> float:
    """Intersection over union of two boxes; 0 where they do not meet."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    return width * height / (_area(a) + _area(b) - width * height)


def _area(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])
