# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A vision on a real bus, with a base beside it that says where it is and what its laser sees."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np

from bus_lab import Lab, until
from edgefusion.bus.clock_id import clock_id
from edgefusion.bus.latest import Latest
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import ODOM, SCAN, Topic
from edgefusion.clock import system_clock
from edgefusion.config import Config
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.messages import Message
from edgefusion.messages.from_odometry import from_odometry
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import load_calibration
from edgefusion.service.vision import Vision
from edgefusion.types import Frame, Health, HealthState, Pose2D, Scan, Twist2D
from scene import cast_scan, paint_frame, write_recording
from vision_scenes import MS

STAMPER = Stamper(1_700_000_000_000_000_000)
WELL = Health("camera", HealthState.OK)
LOST = Health("camera", HealthState.FAILED, "CAMERA_LOST: unplugged")


class PaintedCamera:
    """A picture of the scene every 40 ms, while it is well."""

    def __init__(self) -> None:
        self._image = paint_frame(0.0, 0, np.random.default_rng(1)).image
        self._frames: List[Frame] = []
        self.says = WELL

    def health(self) -> Health:
        return self.says

    def after(self, stamp_ns: int) -> List[Frame]:
        now_ns = system_clock()
        if self.says is WELL and (not self._frames or now_ns - self._frames[-1].stamp_ns >= 40 * MS):
            self._frames = [*self._frames[-9:], Frame(now_ns, self._image)]
        return [frame for frame in self._frames if frame.stamp_ns > stamp_ns]

    def latest(self, max_age_s: float) -> Frame:
        if self.says is not WELL or not self.after(0):
            raise NoFrameError(self.says.reason)
        return self._frames[-1]


class FakeBase:
    """Says a scan ten times a second and its pose with it. clock: the id that its stamps carry."""

    def __init__(self, lab: Lab) -> None:
        self.clock, self.scan = clock_id(), cast_scan(0.0, 1, np.random.default_rng(2))
        self._session, self._tagger, self._due_ns = lab.member(), Tagger(), 0
        self._publishers: Dict[Tuple[Topic, str], Publisher] = {}

    def put(self, topic: Topic, message: Message, stamp_ns: int) -> None:
        publisher = self._publishers.get((topic, self.clock))
        if publisher is None:
            publisher = Publisher(self._session, "robot", topic, self._tagger, self.clock)
            self._publishers[topic, self.clock] = publisher
        publisher.put(message, stamp_ns)

    def speak(self) -> None:
        now_ns = system_clock()
        if now_ns < self._due_ns:
            return
        self._due_ns, stamp_ns = now_ns + 100 * MS, now_ns - 10 * MS
        scan = Scan(stamp_ns, self.scan.ranges_m, self.scan.angle_min, self.scan.angle_increment)
        self.put(ODOM, from_odometry(stamp_ns, Pose2D(1.0, 2.0), Twist2D(), STAMPER), stamp_ns)
        self.put(SCAN, from_scan(scan, STAMPER), stamp_ns)


class VisionLab:
    """All of it; `until` lets it go on until something is so."""

    def __init__(self, stack: ExitStack, folder: Path, make_detector: Callable[[Any], Any], **bus: object) -> None:
        self.lab = Lab(stack, **bus)
        self.router = self.lab.router()
        self.camera, self.base, self.note = PaintedCamera(), FakeBase(self.lab), ""
        calibration = load_calibration(write_recording(folder / "drive") / "calibration.toml")
        self.detector = make_detector(calibration)
        self.vision = Vision(
            Config(bus=self.lab.config),
            calibration,
            self.detector,
            lambda: self.note,
            self.camera,
            STAMPER,
            system_clock,
        )
        self.vision.begin()
        stack.callback(self.vision.end)
        self.laptop = self.lab.client()

    def hear(self, topic: Topic, convert: Callable[[Any], Any]) -> Latest[Any]:
        return Latest(self.laptop, "robot", topic, convert, system_clock)

    def until(self, holds: Callable[[], Any], timeout_s: float = 20.0) -> Any:
        """What it gave when it was so."""
        found: List[Any] = []

        def turn() -> Optional[Any]:
            self.base.speak()
            self.vision.turn()
            found[:] = [holds()]
            return found[0]

        until(turn, timeout_s)
        return found[0]

    def go_on(self, seconds: float) -> None:
        end_s = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end_s)
