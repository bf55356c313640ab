# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The process of the base: robot, laser, navigation and safety, with the bus beside them."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any, Dict, List, Mapping

from edgefusion.bus.arbiter import Arbiter
from edgefusion.bus.requests import StopRequest
from edgefusion.config import BusConfig, Config
from edgefusion.messages.frames import BASE_LINK, LASER
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.transform import FrameTransform, mounting
from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.service.base_bus import BaseBus
from edgefusion.service.base_devices import base_on, lines_to, loop_of
from edgefusion.service.base_inbox import FromVision
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.heartbeat import Heartbeat
from edgefusion.service.helm import Helm
from edgefusion.service.real_time import RealTime
from edgefusion.service.robot_device import RobotReport
from edgefusion.service.teller import Teller
from edgefusion.service.utc import utc_offset_ns
from edgefusion.tools.inspection_files import save_inspection
from edgefusion.types import Pose2D, Scan

KEEPING_S = 1.0

log = logging.getLogger(__name__)


class BaseProcess:
    """run() is for the main thread, once. lock_folder: where ports are locked; None: where all others look."""

    def __init__(self, config: Config, beats: Heartbeat, lock_folder: Path | None = None) -> None:
        self._config, self._beats = config, beats
        self._utc_offset_ns = utc_offset_ns()
        self._lines = lines_to(config, config.robot.port, config.laser.port, lock_folder)
        self._loop = loop_of(config)
        self._helm = Helm(self._loop, _arbiter(config.bus), self._beat)
        self._real_time = RealTime()
        self._base = base_on(config, self._lines, self._loop, self._watch, self._inlet, self._real_time, self._hear)
        stamper = Stamper(self._utc_offset_ns)
        self._bus = BaseBus(config.bus, _mounting(config), stamper, self._helm, self._base, self._figures)
        self._keeper: Teller[InspectionResult] = Teller("keeping inspections", self._keep)
        self._says = "starts"
        if beats.stopped:
            log.warning("stands until `resume`, as the base before this one did: %s", beats.stopped)
            self._helm.stop(StopRequest(beats.stopped))

    def run(self) -> None:
        """Until an exception, as a signal raises it, or the supervisor is gone; the robot is told to stop first.

        Raises PortBusyError where another instance has the robot or the laser.
        """
        self._beat()  # its input was not refused: where another has a port, the supervisor tries again
        self._bus.begin()
        self._keeper.begin()
        try:
            self._base.run()
        finally:
            lateness = self._base.lateness
            log.info("ends; its %d cycles were late by %.1f ms at most", lateness.cycles, lateness.max_ms)
            self._keeper.end(KEEPING_S)
            self._bus.end()

    def _inlet(self, now_ns: int, robot: DeviceNews[RobotReport], laser: DeviceNews[Scan]) -> Inputs:
        self._beat()
        vision: FromVision = self._bus.take(now_ns)
        return Inputs(robot, laser, *vision, self._beats.others(), self._helm.twist(now_ns))

    def _hear(self, scan: Scan) -> None:
        self._bus.tell(scan)

    def _watch(self, outputs: Outputs) -> None:
        self._bus.tell(outputs)
        step = outputs.mission
        self._says = f"{step.state.value}: {step.reason}" if step.reason else step.state.value
        if step.result is not None:
            self._keeper(step.result)

    def _beat(self) -> None:
        """Also says where its robot is, so that somebody else can stop it, and whether the next base is to stand."""
        line, stopped = self._lines.robot, self._loop.ordered_stop
        status: Dict[str, Any] = {"port": line.name, "baudrate": line.baudrate, "says": self._says, "stopped": stopped}
        self._beats.beat(status)
        if self._beats.parent_gone():
            self._base.end()

    def _keep(self, result: InspectionResult) -> None:
        folder = self._config.mission.inspections
        if folder is not None:
            path = save_inspection(Path(folder), result, utc_offset_ns=self._utc_offset_ns)
            log.info("%s of %s is kept as %s", result.id, result.label, path)

    def _figures(self) -> Mapping[str, str]:
        lateness = self._base.lateness
        return {
            "cycles": str(lateness.cycles),
            "lateness p50 [ms]": f"{lateness.p50_ms:.1f}",
            "lateness p99 [ms]": f"{lateness.p99_ms:.1f}",
            "lateness max [ms]": f"{lateness.max_ms:.1f}",
            "real time": str(self._real_time),
            "robot baudrate": str(self._lines.robot.baudrate),
            "cycles with a command too fast": str(self._loop.over_limit),
            "goal_pose refused": str(self._helm.refused_goals),
        }


def _arbiter(config: BusConfig) -> Arbiter:
    timeout_ns = round(config.operator_timeout_s * 1e9) if config.require_operator else None
    return Arbiter(round(config.cmd_vel_timeout_s * 1e9), timeout_ns)


def _mounting(config: Config) -> List[FrameTransform]:
    """By the calibration where there is one, which alone knows of the camera."""
    if config.vision.calibration is None:
        return [FrameTransform(BASE_LINK, LASER, Pose2D(*config.base.laser_pose).matrix())]
    from edgefusion.perception.calibration import load_calibration

    calibration = load_calibration(Path(config.vision.calibration))
    return mounting(calibration.T_base_laser, calibration.T_camera_laser)
