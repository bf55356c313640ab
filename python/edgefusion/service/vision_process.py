# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The process of vision."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Sequence

from edgefusion.clock import Clock, system_clock
from edgefusion.config import Config
from edgefusion.drivers.camera import Camera
from edgefusion.errors import RefusedError
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.runtime_options import runtime_options
from edgefusion.service.heartbeat import Heartbeat
from edgefusion.service.real_time import scheduling
from edgefusion.service.robot_camera import RobotCamera
from edgefusion.service.robot_clock import RobotClock
from edgefusion.service.robot_time import Known, robot_time
from edgefusion.service.utc import utc_offset_ns
from edgefusion.service.vision import Vision

TURN_S = 0.05

log = logging.getLogger(__name__)


def run_vision(config: Config, beats: Heartbeat, clock: Clock = system_clock) -> None:
    """Until an exception, as a signal raises it, or the supervisor is gone.

    Raises RefusedError for a model, a calibration or a provider that will not do, before the camera is touched;
    RuntimeError where the network has failed for good, and where another computer's robot was started anew.
    """
    settings, start_ns = config.vision, clock()
    if settings.model is None or settings.calibration is None:
        raise RefusedError("vision.model: expected a model folder, without which there is no vision, got none")
    calibration = load_calibration(Path(settings.calibration))
    groups = LabelGroups.load(None if settings.groups is None else Path(settings.groups))
    classifier = open_classifier(Path(settings.model), options=runtime_options(settings))
    log.info("%s runs on %s, %s", settings.model, classifier.provider, scheduling())
    _warn_of_unknown(config.mission.interest, groups, classifier.labels)
    detector = Detector(classifier, calibration, config.perception, groups, clock)
    with robot_time(config.bus) as known:
        robot_clock = _known(known, beats)
        if robot_clock is None:
            return
        with Camera(config.camera, clock) as camera:
            stamper = Stamper(utc_offset_ns() - robot_clock.ahead_ns)
            vision = Vision(
                config,
                calibration,
                detector,
                lambda: classifier.provider_note,
                RobotCamera(camera, robot_clock),
                stamper,
                robot_clock,
                robot_clock.id,
            )
            vision.begin()
            try:
                _see(vision, beats, robot_clock.of(start_ns), known)
            finally:
                vision.end()


def _warn_of_unknown(interest: Sequence[str], groups: LabelGroups, labels: Sequence[str]) -> None:
    """It is no reason not to see: goals may bring what they are interested in."""
    for name in interest:
        try:
            groups.labels_of(name, labels)
        except RefusedError as error:
            log.warning("mission.interest: never seen: %s", error)


def _known(known: Known, beats: Heartbeat) -> RobotClock | None:
    """The robot's clock, once it is known; None where the supervisor is gone before."""
    said = False
    while not beats.parent_gone():
        clock = known()
        if clock is not None:
            if said:
                log.info("the robot's clock is read, give or take %.1f ms", clock.error_ns / 1e6)
            return clock
        if not said:
            log.info("waits for base, to read the robot's clock")
            said = True
        beats.beat({"says": "waits for base, to read the robot's clock"})
        time.sleep(TURN_S)
    return None


def _see(vision: Vision, beats: Heartbeat, start_ns: int, known: Known) -> None:
    seen = False
    while not beats.parent_gone():
        beats.beat({"says": vision.says})
        look = vision.turn()
        known()
        if look is not None and not seen:
            log.info("first look %.1f s after the start", (look.ended_ns - start_ns) / 1e9)
            seen = True
