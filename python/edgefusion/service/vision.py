# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Vision at work: a camera and a detector, with scans and odometry from the bus, and what is seen put there."""

from __future__ import annotations

import logging
from typing import Callable

from edgefusion.bus.clock_id import clock_id
from edgefusion.clock import Clock
from edgefusion.config import Config
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import Calibration
from edgefusion.service.real_time import scheduling
from edgefusion.service.vision_bus import News, VisionBus
from edgefusion.service.vision_eye import CameraDriver, Eye
from edgefusion.service.vision_inspections import VisionInspections
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_loop import Detects, VisionLoop
from edgefusion.service.vision_odometry import VisionOdometry
from edgefusion.service.vision_pictures import VisionPictures
from edgefusion.service.vision_state import Circumstances, VisionState
from edgefusion.service.vision_watch import Status
from edgefusion.types import Health, HealthState
from edgefusion.waiting import Wake

TURN_S = 0.02
"""So often the camera is asked; a scan ends the wait."""

log = logging.getLogger(__name__)


class Vision:
    """note: why the network does not run on what it was to run on, empty where it does. clock: the robot's, by which
    the camera stamps, too; robot_clock_id: its name, where it is not this computer's. For one thread."""

    def __init__(
        self,
        config: Config,
        calibration: Calibration,
        detector: Detects,
        note: Callable[[], str],
        camera: CameraDriver,
        stamper: Stamper,
        clock: Clock,
        robot_clock_id: str | None = None,
    ) -> None:
        self._note, self._clock = note, clock
        eye = Eye(camera, config.camera, calibration.camera_latency_ns)
        pictures = VisionPictures(calibration, config.perception, config.bus.jpeg_quality)
        self._odometry, self._wake = VisionOdometry(), Wake()
        self._loop = VisionLoop(detector, eye, self._odometry, config.sync, clock)
        self._state = VisionState(clock(), config.sync.tolerance_s)
        self._inspections = VisionInspections(config.mission.same_place_m, pictures.annotated)
        self.status = Status(self._state.health(clock(), Circumstances()), {})
        self._bus = VisionBus(
            config,
            calibration,
            eye,
            pictures,
            stamper,
            lambda: self.status,
            self._wake,
            clock,
            robot_clock_id or clock_id(),
        )

    def begin(self) -> None:
        """Looks for the bus, and returns at once."""
        self._bus.begin()

    def end(self) -> None:
        """Leaves the bus."""
        self._bus.end()

    @property
    def says(self) -> str:
        """What it does, in a few words."""
        health = self.status.health
        return f"{health.state.value}: {health.reason}" if health.reason else f"sees {self._state.rate_hz:.1f} frames/s"

    def turn(self) -> Look | None:
        """Waits for news a little, and looks where there are any. Raises RuntimeError where the network has failed."""
        self._wake.wait(TURN_S)
        news = self._bus.take(self._odometry)
        for request in news.requests:
            self._inspections.ask(request)
        if news.scans:
            self._state.scanned(self._clock())
        look = self._loop.step(news.scans)
        if look is not None:
            self._tell(look)
        self._tell_state(news)
        return look

    def _tell(self, look: Look) -> None:
        self._state.looked(look)
        self._bus.tell(look)
        answer = self._inspections.look(look)
        if answer is not None:
            self._bus.answer(answer)

    def _tell_state(self, news: News) -> None:
        now_ns = self._clock()
        late = self._inspections.expire(now_ns, self._loop.trouble)
        if late is not None:
            self._bus.answer(late)
        before = self.status.health
        health = self._state.health(now_ns, Circumstances(self._loop.trouble, news.refused, self._note()))
        figures = {"pairs overtaken": str(self._loop.overtaken), "scheduling": scheduling()}
        self.status = Status(health, {**self._state.figures(), **figures})
        _log_change(before, health)


def _log_change(before: Health, now: Health) -> None:
    """Of a reason only its first words are compared: what comes then may count."""
    if (before.state, before.reason.split(" ")[:3]) == (now.state, now.reason.split(" ")[:3]):
        return
    level = logging.INFO if now.state in (HealthState.OK, HealthState.STARTING) else logging.WARNING
    log.log(level, "%s: %s%s", now.component, now.state.value, f": {now.reason}" if now.reason else "")
