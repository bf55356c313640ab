# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Vision as `edgefusion vision` runs it, with a network that is as many times slower: `slow_vision CONFIG TIMES`.

Each look is a line: when its frame was captured, and when it was begun and ended [ns], and how many pairs nobody
looked at so far.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import List

import numpy as np

from edgefusion.clock import system_clock
from edgefusion.config import load_config
from edgefusion.drivers.camera import Camera
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.service.utc import utc_offset_ns
from edgefusion.service.vision import Vision
from edgefusion.types import STILL, Detection, Frame, Pose2D, Scan

BOXES = 4


class SlowDetector(Detector):
    """It names some boxes, so many times over, before it looks."""

    def __init__(self, classifier: Classifier, times: int, *arguments: object) -> None:
        super().__init__(classifier, *arguments)  # type: ignore[arg-type]
        self._slow, self._times = classifier, times

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> List[Detection]:
        height, width = frame.image.shape[:2]
        boxes = np.tile(np.array([[0, 0, width, height]], np.int32), (BOXES, 1))
        for _ in range(self._times):
            self._slow.infer(self._slow.crop(frame.image, boxes))
        return super().detect(scan, frame, motion)


def main() -> None:
    """Until it is killed."""
    config, times = load_config(Path(sys.argv[1])), int(sys.argv[2])
    calibration = load_calibration(Path(str(config.vision.calibration)))
    detector = SlowDetector(open_classifier(Path(str(config.vision.model))), times, calibration, config.perception)
    with Camera(config.camera, system_clock) as camera:
        stamper = Stamper(utc_offset_ns())
        vision = Vision(config, calibration, detector, lambda: "", camera, stamper, system_clock)
        vision.begin()
        while True:
            look = vision.turn()
            if look is not None:
                print(
                    look.frame.stamp_ns,
                    look.begun_ns,
                    look.ended_ns,
                    vision.status.figures.get("pairs overtaken", "0"),
                    flush=True,
                )


if __name__ == "__main__":
    main()
