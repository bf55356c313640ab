# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The process of vision."""

from __future__ import annotations

import logging
from pathlib import Path

from edgefusion.clock import Clock, system_clock
from edgefusion.config import Config, VisionConfig
from edgefusion.drivers.camera import Camera
from edgefusion.errors import RefusedError
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.network import RuntimeOptions
from edgefusion.service.heartbeat import Heartbeat
from edgefusion.service.real_time import scheduling
from edgefusion.service.utc import utc_offset_ns
from edgefusion.service.vision import Vision

log = logging.getLogger(__name__)


def run_vision(config: Config, beats: Heartbeat, clock: Clock = system_clock) -> None:
    """Until an exception, as a signal raises it, or the supervisor is gone.

    Raises RefusedError for a model, a calibration or a provider that will not do, before the camera is touched;
    RuntimeError where the network has failed for good.
    """
    settings, start_ns = config.vision, clock()
    if settings.model is None or settings.calibration is None:
        raise RefusedError("vision.model: expected a model folder, without which there is no vision, got none")
    calibration = load_calibration(Path(settings.calibration))
    groups = LabelGroups.load(None if settings.groups is None else Path(settings.groups))
    classifier = open_classifier(Path(settings.model), options=runtime_options(settings))
    log.info("%s runs on %s, %s", settings.model, classifier.provider, scheduling())
    detector = Detector(classifier, calibration, config.perception, groups, clock)
    with Camera(config.camera, clock) as camera:
        stamper = Stamper(utc_offset_ns())
        vision = Vision(config, calibration, detector, lambda: classifier.provider_note, camera, stamper, clock)
        vision.begin()
        try:
            _see(vision, beats, start_ns)
        finally:
            vision.end()


def _see(vision: Vision, beats: Heartbeat, start_ns: int) -> None:
    seen = False
    while not beats.parent_gone():
        beats.beat({"says": vision.says})
        look = vision.turn()
        if look is not None and not seen:
            log.info("first look %.1f s after the start", (look.ended_ns - start_ns) / 1e9)
            seen = True


def runtime_options(settings: VisionConfig) -> RuntimeOptions:
    """As they are meant in the configuration. Raises RefusedError."""
    if settings.require_provider and settings.provider != "auto":
        return RuntimeOptions(provider=settings.provider, require=settings.provider, threads=settings.threads)
    return RuntimeOptions(provider=settings.provider, threads=settings.threads)
