# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures of what was seen, as JPEG."""

from __future__ import annotations

from typing import Sequence

from edgefusion.config import PerceptionConfig
from edgefusion.messages.pictures import encode_jpeg
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import find_clusters
from edgefusion.service.vision_look import Look
from edgefusion.tools.draw import annotate
from edgefusion.types import Detection


class VisionPictures:
    """quality: JPEG's, 1 to 100."""

    def __init__(self, calibration: Calibration, config: PerceptionConfig, quality: int) -> None:
        self._calibration, self._config, self._quality = calibration, config, quality

    def annotated(self, look: Look, detections: Sequence[Detection]) -> bytes:
        """The frame with the scan's beams, and boxes, labels and distances of these detections."""
        clusters = find_clusters(look.scan, self._config)
        return encode_jpeg(
            annotate(look.frame.image, detections, look.scan, clusters, self._calibration), self._quality
        )
