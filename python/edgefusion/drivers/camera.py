# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A camera: a thread that reads all the time, from a child that may hang, and what it has seen lately."""

from __future__ import annotations

import threading
from functools import partial
from types import TracebackType

from edgefusion.clock import Clock, system_clock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_loop import CaptureLoop, Opener
from edgefusion.drivers.camera_open import open_source
from edgefusion.types import Frame, Health
from edgefusion.waiting import Wake, join

TURN_S = 0.05
"""How long a turn waits for a picture: closing is noticed after it."""
IDLE_S = 0.02
"""The pause between turns while nothing is open."""
JOIN_S = 2.0


class Camera:
    """Captures from its making until `close`. Nothing here waits for the device, and no failure of it is raised.

    clock: of the process's pictures and ages; that of a real device must be `system_clock`, whose time its child
    stamps with. opener: what to read from, by default what the configuration says.
    """

    def __init__(self, config: CameraConfig, clock: Clock = system_clock, opener: Opener | None = None) -> None:
        self._loop = CaptureLoop(opener or partial(open_source, config, clock), config, clock)
        self._ending, self._wake = False, Wake()
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._ending:
            if not self._loop.step(TURN_S):
                self._wake.wait(IDLE_S)
        self._loop.close()

    def latest(self, max_age_s: float) -> Frame:
        """The newest picture. Raises NoFrameError, with the reason, where it is old, frozen or blind, or none came."""
        return self._loop.latest(max_age_s)

    def after(self, stamp_ns: int) -> list[Frame]:
        """The kept pictures with later stamps, in order; none that came while the camera was frozen or blind."""
        return self._loop.after(stamp_ns)

    def health(self) -> Health:
        """How the camera is now; its reasons begin with CAMERA_STARTING, _LOST, _FROZEN or _BLIND."""
        return self._loop.health()

    def close(self) -> None:
        """Ends the capture and kills what hangs in it, within about two seconds."""
        self._ending = True
        self._wake()
        join(self._thread, JOIN_S)

    def __enter__(self) -> Camera:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
