# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What vision saw in one frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from edgefusion.perception.detector import StageTimes
from edgefusion.types import Detection, Frame, Pose2D, Scan


@dataclass(frozen=True)
class Look:
    """A scan and a frame that were captured together, and what the detector found in them, the nearest first.

    pose: of the robot in `odom` at the frame's stamp, None where nobody says it. begun_ns, ended_ns: of the detector's
    work; times: how it was spent.
    """

    scan: Scan
    frame: Frame
    pose: Pose2D | None
    detections: Tuple[Detection, ...]
    times: StageTimes
    begun_ns: int
    ended_ns: int

    @property
    def age_ns(self) -> int:
        """From the frame's capture until it was known what is in it."""
        return self.ended_ns - self.frame.stamp_ns
