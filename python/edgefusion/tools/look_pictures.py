# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures of one look at a world: what the camera saw with its boxes, and the scan from above. BGR uint8."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import cv2
import numpy as np

from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import find_clusters
from edgefusion.perception.motion import laser_motion
from edgefusion.sim.snapshot import Snapshot
from edgefusion.tools.draw import Image, annotate, draw_scan
from edgefusion.types import Detection

SCAN_SIDE_PX = 640


class LookPictures:
    """Draws looks at worlds, as the detector saw them."""

    def __init__(self, calibration: Calibration, config: PerceptionConfig) -> None:
        self._calibration, self._config = calibration, config

    def camera(self, shot: Snapshot, detections: Sequence[Detection]) -> Image:
        """The image with beams and the boxes of some detections; the beams are where they were at the frame's stamp."""
        T_moved = self._calibration.T_camera_laser @ laser_motion(shot.motion, self._calibration.T_base_laser)
        moved = replace(self._calibration, T_camera_laser=T_moved)
        return annotate(
            shot.frame.image, _by_label(detections), shot.scan, find_clusters(shot.scan, self._config), moved
        )

    def scan(self, shot: Snapshot, detections: Sequence[Detection], side_px: int = SCAN_SIDE_PX) -> Image:
        """The scan from above with the names of some detections, the robot looking up."""
        scan = shot.scan
        return draw_scan(scan, find_clusters(scan, self._config), _by_label(detections), side_px)

    def everything(self, shot: Snapshot, detections: Sequence[Detection]) -> Image:
        """Camera and scan side by side."""
        camera = self.camera(shot, detections)
        return np.asarray(cv2.hconcat([camera, self.scan(shot, detections, camera.shape[0])]))


def _by_label(detections: Sequence[Detection]) -> list[Detection]:
    """Named by their labels, which the truth has too, instead of by their groups."""
    return [replace(detection, group="") for detection in detections]
