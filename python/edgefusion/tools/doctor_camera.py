# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the camera opens, gives pictures that change, and is exposed well."""

from __future__ import annotations

import time
from typing import Callable, Iterator

import numpy as np

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.camera import Camera
from edgefusion.drivers.camera_open import device_path, source_name
from edgefusion.tools.doctor_finding import Examination, Finding, State
from edgefusion.types import Frame, Health, HealthState

_TURN_S, _SLACK_S = 0.02, 0.3
_DARK, _BRIGHT, _CLIPPED = 30, 225, 250
"""Grey levels: of a picture's mean, and where a pixel says nothing any more."""

_CLIPPED_SHARE = 0.3
_LEAST_SHARE = 0.7
"""Of the rate that is configured."""

_CURES = {
    "CAMERA_LOST": "look at its plug and [camera] source; what the device does not take is named, leave that out",
    "CAMERA_FROZEN": "unplug it and plug it in; look at its cable and its power",
    "CAMERA_BLIND": "take the cap off, give it light, set [camera] exposure_s",
    "CAMERA_STARTING": "raise [camera] open_timeout_s",
}


def check_camera(
    exam: Examination, clock: Clock = system_clock, pause: Callable[[float], None] = time.sleep
) -> Iterator[Finding]:
    """Watches it for as long as it takes to tell frozen and blind ones."""
    config = exam.config.camera
    if not exam.runs("vision"):
        yield Finding("camera", State.SKIPPED, exam.why_no_vision())
        return
    if str(device_path(config)) in exam.unusable:
        yield Finding("camera", State.SKIPPED, "its device cannot be used")
        return
    with Camera(config, clock) as camera:
        seen = Seen()
        _wait(config.open_timeout_s, lambda: camera.health().state is HealthState.OK, clock, pause)
        if camera.health().state is HealthState.OK:
            _wait(max(config.frozen_s, config.blind_s), lambda: seen.look(camera), clock, pause)
        health = camera.health()
    yield _judged(exam, seen, health)


class Seen:
    """The pictures of a while. newest: None where none came."""

    def __init__(self) -> None:
        self._first_ns, self._count = 0, 0
        self.newest: Frame | None = None

    def look(self, camera: Camera) -> bool:
        """Takes the pictures since the last look; it is never enough."""
        for frame in camera.after(self.newest.stamp_ns if self.newest else 0):
            self._first_ns = self._first_ns or frame.stamp_ns
            self._count += 1
            self.newest = frame
        return False

    @property
    def rate_hz(self) -> float:
        """Pictures a second; 0 before the second one."""
        span_ns = self.newest.stamp_ns - self._first_ns if self.newest else 0
        return (self._count - 1) * 1e9 / span_ns if span_ns else 0.0


def _wait(seconds: float, enough: Callable[[], bool], clock: Clock, pause: Callable[[float], None]) -> None:
    end_ns = clock() + round((seconds + _SLACK_S) * 1e9)
    while clock() < end_ns and not enough():
        pause(_TURN_S)


def _judged(exam: Examination, seen: Seen, health: Health) -> Finding:
    name, frame = source_name(exam.config.camera), seen.newest
    if health.state is not HealthState.OK or frame is None or not seen.rate_hz:
        reason = health.reason or "CAMERA_STARTING: expected pictures, got hardly any"
        return Finding("camera", State.FAILED, f"{name}: {reason}", _CURES[reason.partition(":")[0]])
    height, width = frame.image.shape[:2]
    exam.picture_size = (width, height)
    text, exposure = f"{name}: {width}x{height}, {seen.rate_hz:.0f} pictures a second", _exposure(frame)
    wanted_hz = exam.config.camera.rate_hz
    if wanted_hz is not None and seen.rate_hz < _LEAST_SHARE * wanted_hz:
        cure = "give it light or a shorter exposure, a USB port of its own, smaller pictures; or set [camera] rate_hz"
        return Finding("camera", State.WARNING, f"{text}, not {wanted_hz:g}", cure)
    if exposure:
        cure = "set [camera] exposure_s, or look at the light"
        return Finding("camera", State.WARNING, f"{text}; {exposure}", cure)
    return Finding("camera", State.OK, text)


def _exposure(frame: Frame) -> str:
    """What is wrong with it, in words."""
    mean, clipped = float(frame.image.mean()), float((frame.image >= _CLIPPED).mean())
    if mean < _DARK:
        return f"too dark: {mean:.0f} of 255 on average"
    if mean > _BRIGHT or clipped > _CLIPPED_SHARE:
        return f"too bright: {mean:.0f} of 255 on average, {np.round(100 * clipped):.0f} % at the end of the scale"
    return ""
