# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Vision in a time of its own: a camera that is told what to show, a detector that takes as long as it is told."""

from __future__ import annotations

from typing import Callable, List, Optional, Sequence

import numpy as np

from bus_base import detection
from camera_scenes import scene
from edgefusion.clock import Clock, SimClock
from edgefusion.config import CameraConfig, SyncConfig
from edgefusion.drivers.camera_loop import CaptureLoop
from edgefusion.drivers.camera_pipe import PipeEndedError
from edgefusion.drivers.camera_source import Picture
from edgefusion.perception.detector import StageTimes
from edgefusion.service.vision_eye import Eye
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_loop import VisionLoop
from edgefusion.service.vision_odometry import VisionOdometry
from edgefusion.types import STILL, Detection, Frame, Pose2D, Scan

MS = 1_000_000


def scan(stamp_ns: int, range_m: float = 2.0) -> Scan:
    return Scan(stamp_ns, np.full(7, range_m, np.float32), -0.3, 0.1)


class _Told:
    """What a camera is read from."""

    def __init__(self) -> None:
        self.picture: Optional[Picture] = None
        self.ends = ""

    def read(self, timeout_s: float) -> Optional[Picture]:
        if self.ends:
            raise PipeEndedError(self.ends)
        picture, self.picture = self.picture, None
        return picture

    def close(self) -> None:
        self.picture = None


class ToldCamera(CaptureLoop):
    """The camera's own loop over what it is told to show, with its judgement of that."""

    def __init__(self, clock: Clock, config: Optional[CameraConfig] = None) -> None:
        self._told, self._now = _Told(), clock
        super().__init__(lambda: self._told, config or CameraConfig(), clock)

    def show(self, image: np.ndarray) -> None:
        """A camera that is not open does not see it."""
        self.step(0)
        self._told.picture = Picture(self._now(), image)
        self.step(0)


class ToldDetector:
    """Finds the same thing in every frame. meanwhile: what happens while it is at work."""

    def __init__(self, meanwhile: Callable[[], None] = lambda: None) -> None:
        self.times = StageTimes(1 * MS, 2 * MS, 3 * MS, 4 * MS)
        self.meanwhile, self.motions, self.frames = meanwhile, [], []

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> List[Detection]:
        self.motions.append(motion)
        self.frames.append(frame)
        self.meanwhile()
        return [detection(frame.stamp_ns)]


class Bench:
    """frame_ms, scan_ms: how often what comes; each frame shows something else, until `shows` says what."""

    def __init__(self, camera: Optional[CameraConfig] = None, frame_ms: int = 40, scan_ms: int = 80, late_ms: int = 20):
        self.clock, self.odometry, self.detector = SimClock(10_000 * MS), VisionOdometry(), ToldDetector()
        self.camera = ToldCamera(self.clock, camera)
        self.eye = Eye(self.camera, camera or CameraConfig(), 0)
        self.loop = VisionLoop(self.detector, self.eye, self.odometry, SyncConfig(), self.clock)
        self.shows: Callable[[int], Optional[np.ndarray]] = scene
        self._frame_ms, self._scan_ms, self._late_ms, self._ms = frame_ms, scan_ms, late_ms, 0
        self._scans: List[Scan] = []

    def pass_ms(self, ms: int) -> None:
        """Frames and scans come meanwhile, and nobody looks."""
        for _ in range(ms):
            self._ms += 1
            now_ns = self.clock.advance(MS)
            if self._ms % self._frame_ms == 0:
                image = self.shows(self._ms)
                if image is not None:
                    self.camera.show(image)
            if self._ms % self._scan_ms == self._late_ms:
                self._scans.append(scan(now_ns - self._late_ms * MS))

    def turn(self) -> Optional[Look]:
        scans, self._scans = self._scans[-4:], []
        return self.loop.step(scans)

    def look_for(self, ms: int, turn_ms: int = 5) -> Sequence[Look]:
        """Turns for so long; what was seen in them."""
        end_ns, looks = self.clock() + ms * MS, []
        while self.clock() < end_ns:
            self.pass_ms(turn_ms)
            look = self.turn()
            if look is not None:
                looks.append(look)
        return looks
