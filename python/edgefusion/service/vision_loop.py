# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A turn of vision: what the sensors gave is paired, and the detector looks at the newest pair."""

from __future__ import annotations

from typing import List, Protocol, Sequence

from edgefusion.clock import Clock
from edgefusion.config import SyncConfig
from edgefusion.drivers.camera_picture import Sight, sight
from edgefusion.perception.detector import StageTimes
from edgefusion.perception.sync import Pair
from edgefusion.service.vision_eye import Eye
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_odometry import VisionOdometry
from edgefusion.service.vision_pairing import NewestPair
from edgefusion.types import STILL, Detection, Frame, Pose2D, Scan


class Detects(Protocol):
    """As perception.detector.Detector does."""

    times: StageTimes

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> List[Detection]: ...


class VisionLoop:
    """For one thread."""

    def __init__(self, detector: Detects, eye: Eye, odometry: VisionOdometry, config: SyncConfig, clock: Clock) -> None:
        self._detector, self._eye, self._odometry, self._clock = detector, eye, odometry, clock
        self._pairs, self._frame_ns = NewestPair(config), 0
        self._lost, self._refusal = "", ""

    @property
    def trouble(self) -> str:
        """Why nothing is seen now, of the camera or of its frames; empty where all is well."""
        return self._lost or self._refusal

    @property
    def overtaken(self) -> int:
        """How many pairs nobody looked at, as newer ones were there."""
        return self._pairs.overtaken

    def step(self, scans: Sequence[Scan]) -> Look | None:
        """What is to be seen, where a pair is complete with these and what the camera gave meanwhile."""
        self._lost = self._eye.trouble
        if self._lost:
            self._pairs.forget()
            return None
        frames = self._eye.after(self._frame_ns)
        if frames:
            self._frame_ns = frames[-1].stamp_ns
        pair = self._pairs.add(scans, frames)
        return self._look(pair) if pair is not None and self._is_worth_it(pair.frame) else None

    def _is_worth_it(self, frame: Frame) -> bool:
        """A black picture is none from the first on, long before the camera counts as blind."""
        return self._eye.is_fresh and sight(frame.image) is Sight.CLEAR

    def _look(self, pair: Pair) -> Look | None:
        begun_ns = self._clock()
        before, pose = self._odometry.at(pair.scan.stamp_ns), self._odometry.at(pair.frame.stamp_ns)
        motion = STILL if before is None or pose is None else pose.relative_to(before)
        try:
            detections = self._detector.detect(*pair, motion)
        except ValueError as error:  # a frame that is not of the calibration's size
            self._refusal = str(error)
            return None
        self._refusal = ""
        if not self._eye.is_fresh:  # of this very frame it was found out meanwhile, perhaps
            return None
        return Look(*pair, pose, tuple(detections), self._detector.times, begun_ns, self._clock())
