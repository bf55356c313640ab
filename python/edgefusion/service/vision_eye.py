# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The camera as vision looks through it: frames stamped with when they were captured, and whether to trust them."""

from __future__ import annotations

from dataclasses import replace
from typing import List, Protocol

from edgefusion.config import CameraConfig
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.types import Frame, Health, HealthState


class CameraDriver(Protocol):
    """As drivers.camera.Camera is."""

    def latest(self, max_age_s: float) -> Frame: ...

    def after(self, stamp_ns: int) -> List[Frame]: ...

    def health(self) -> Health: ...


class Eye:
    """latency_ns: the calibration's, from capture to the stamp that the camera gives. From any thread, never waits."""

    def __init__(self, camera: CameraDriver, config: CameraConfig, latency_ns: int) -> None:
        self._camera, self._latency_ns = camera, latency_ns
        # What it has shown last is too old before the camera counts as lost.
        self._fresh_s = config.lost_s / 2

    @property
    def health(self) -> Health:
        return self._camera.health()

    @property
    def trouble(self) -> str:
        """What is wrong with the camera; empty where it sees."""
        health = self._camera.health()
        return "" if health.state is HealthState.OK else health.reason

    @property
    def is_fresh(self) -> bool:
        """Whether it sees, and showed something a moment ago."""
        try:
            self._camera.latest(self._fresh_s)
        except NoFrameError:
            return False
        return True

    def after(self, stamp_ns: int) -> List[Frame]:
        """The frames that were captured later, in order."""
        frames = self._camera.after(stamp_ns + self._latency_ns)
        return [replace(frame, stamp_ns=frame.stamp_ns - self._latency_ns) for frame in frames]
