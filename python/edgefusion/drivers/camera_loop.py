# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One turn of capturing after the other: open, read, judge, keep; what hangs is abandoned and opened again."""

from __future__ import annotations

import threading
from typing import Callable

from edgefusion.clock import Clock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_pipe import PipeEndedError
from edgefusion.drivers.camera_ring import Arrival, FrameRing, NoFrameError
from edgefusion.drivers.camera_source import Picture, PictureSource
from edgefusion.drivers.camera_state import CameraState
from edgefusion.types import Frame, Health, HealthState

Opener = Callable[[], PictureSource]
"""Starts to capture. Raises PipeEndedError where it cannot."""

_TURN_NS = 200_000_000
"""No turn waits for longer: a process that was halted has not seen its camera hang meanwhile."""


class CaptureLoop:
    """What the thread of a camera repeats. `step` is that thread's; the rest is anyone's, and never waits for it."""

    def __init__(self, open_source: Opener, config: CameraConfig, clock: Clock) -> None:
        self._open_source, self._config, self._clock = open_source, config, clock
        self._ring = FrameRing(round(config.keep_s * 1e9), clock)
        self._state, self._lock = CameraState(config), threading.Lock()
        self._source: PictureSource | None = None
        self._turn_ns = self._patience_ns = 0
        self._first_arrival_ns: int | None = None  # of the source that is open
        self._pause_s, self._open_at_ns = config.first_pause_s, clock()

    def step(self, timeout_s: float) -> bool:
        """Opens when it is time, or waits so long for a picture. False: nothing is open, so nothing was waited for."""
        if self._source is None:
            return self._clock() >= self._open_at_ns and self._open()
        try:
            picture = self._source.read(timeout_s)
        except PipeEndedError as error:
            self._give_up(str(error))
            return False
        if picture is not None:
            self._take(picture)
        elif self._is_out_of_patience():
            self._give_up("it hangs, and is opened again")
        return self._source is not None

    def _is_out_of_patience(self) -> bool:
        before_ns, self._turn_ns = self._turn_ns, self._clock()
        self._patience_ns -= min(self._turn_ns - before_ns, _TURN_NS)
        return self._patience_ns < 0

    def _be_patient(self, for_s: float) -> None:
        self._turn_ns, self._patience_ns = self._clock(), round(for_s * 1e9)

    def _open(self) -> bool:
        try:
            self._source = self._open_source()
        except PipeEndedError as error:
            self._give_up(str(error))
            return False
        self._first_arrival_ns = None
        self._be_patient(self._config.open_timeout_s)
        return True

    def _take(self, picture: Picture) -> None:
        self._be_patient(self._config.read_timeout_s)
        if self._first_arrival_ns is None:
            self._first_arrival_ns = picture.arrival_ns
        with self._lock:
            self._state.take(picture.arrival_ns, picture.image)
            fault, is_frozen = self._state.fault, self._state.is_frozen
        if not fault:
            self._keep(picture)
            return
        self._ring.clear()
        # OpenCV gives the last picture for ever where a device has gone. One that is just opened may begin with it.
        if is_frozen and picture.arrival_ns - self._first_arrival_ns >= self._config.frozen_s * 1e9:
            self._pause()

    def _keep(self, picture: Picture) -> None:
        stamp_ns = picture.arrival_ns - round(self._config.exposure_offset_s * 1e9)
        self._ring.add(Arrival(picture.arrival_ns, Frame(stamp_ns, picture.image)))
        self._pause_s = self._config.first_pause_s

    def _give_up(self, reason: str) -> None:
        with self._lock:
            self._state.fail(reason)
        self._pause()

    def _pause(self) -> None:
        """Closes; the next attempt comes later each time, until a good picture has come."""
        self.close()
        self._open_at_ns = self._clock() + round(self._pause_s * 1e9)
        self._pause_s = min(2 * self._pause_s, self._config.longest_pause_s)

    def close(self) -> None:
        """Lets go of the device; only for the thread that steps, or after it has ended."""
        if self._source is not None:
            self._source.close()
            self._source = None

    def health(self) -> Health:
        """How the camera is now."""
        with self._lock:
            return self._state.health(self._clock())

    def latest(self, max_age_s: float) -> Frame:
        """The newest picture. Raises NoFrameError, with the reason, where it is old, frozen or blind, or none came."""
        health = self.health()
        if health.state is not HealthState.OK:
            raise NoFrameError(health.reason)
        return self._ring.latest(round(max_age_s * 1e9))

    def after(self, stamp_ns: int) -> list[Frame]:
        """The kept pictures with later stamps, in order; none that came while the camera was frozen or blind."""
        return self._ring.after(stamp_ns)
