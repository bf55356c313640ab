# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a camera is, from the pictures that came and the time: no clock is read, no device touched."""

from __future__ import annotations

from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_picture import Image, Repetition, Sight, sight
from edgefusion.types import Health, HealthState

COMPONENT = "camera"
STARTING = "CAMERA_STARTING"
LOST = "CAMERA_LOST"
FROZEN = "CAMERA_FROZEN"
BLIND = "CAMERA_BLIND"


class CameraState:
    """What is told of a camera: its failures, its pictures. Its reasons begin with the code that others look for."""

    def __init__(self, config: CameraConfig) -> None:
        self._config = config
        self._repetition = Repetition()
        self._newest_ns: int | None = None
        self._failure = ""
        self._blind_since_ns: int | None = None
        self._fault = ""

    @property
    def fault(self) -> str:
        """Why the newest picture is not to be used: frozen or blind. Empty: it is."""
        return self._fault

    @property
    def is_frozen(self) -> bool:
        """Whether the newest picture is the same as those for so long before it."""
        return self._fault.startswith(FROZEN)

    def take(self, arrival_ns: int, image: Image) -> None:
        """A picture came."""
        self._newest_ns, self._failure = arrival_ns, ""
        same_ns = self._repetition.lasts_ns(arrival_ns, image)
        seen = sight(image)
        if seen is Sight.CLEAR:
            self._blind_since_ns = None
        elif self._blind_since_ns is None:
            self._blind_since_ns = arrival_ns
        self._fault = self._judged(arrival_ns, same_ns, seen)

    def _judged(self, arrival_ns: int, same_ns: int, seen: Sight) -> str:
        if self._blind_since_ns is not None and arrival_ns - self._blind_since_ns >= self._config.blind_s * 1e9:
            return f"{BLIND}: {seen.value} pictures for {(arrival_ns - self._blind_since_ns) / 1e9:.1f} s"
        if same_ns >= self._config.frozen_s * 1e9:
            return f"{FROZEN}: the same picture for {same_ns / 1e9:.1f} s"
        return ""

    def fail(self, reason: str) -> None:
        """No picture comes any more, or it could not be opened."""
        self._failure = reason

    def health(self, now_ns: int) -> Health:
        """How it is at a time: a camera that falls silent is lost without anyone telling."""
        if self._failure:
            return self._failed(f"{LOST}: {self._failure}")
        if self._newest_ns is None:
            return Health(COMPONENT, HealthState.STARTING, f"{STARTING}: no picture yet")
        if self.is_frozen:  # while it is opened again nothing comes, and it is frozen still
            return self._failed(self._fault)
        age_ns = now_ns - self._newest_ns
        if not 0 <= age_ns <= self._config.lost_s * 1e9:
            return self._failed(f"{LOST}: the newest picture is {age_ns / 1e9:.1f} s old")
        return self._failed(self._fault) if self._fault else Health(COMPONENT, HealthState.OK)

    @staticmethod
    def _failed(reason: str) -> Health:
        return Health(COMPONENT, HealthState.FAILED, reason)
