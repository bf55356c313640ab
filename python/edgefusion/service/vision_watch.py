# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What vision tells at its own pace, also while the detector is busy: how it is, and the camera's images."""

from __future__ import annotations

import logging
import threading
from typing import Callable, Mapping, NamedTuple, Tuple

from edgefusion.bus import topics
from edgefusion.clock import Clock
from edgefusion.config import BusConfig
from edgefusion.messages.from_camera_info import from_camera_info
from edgefusion.messages.from_healths import from_healths
from edgefusion.messages.from_image import from_image
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.stamps import Stamper
from edgefusion.service.on_change import OnChange
from edgefusion.service.vision_eye import Eye
from edgefusion.service.vision_outlet import ALL_HZ, MakePublisher
from edgefusion.types import Health
from edgefusion.waiting import Wake, join

TURN_S = 0.05

log = logging.getLogger(__name__)


class Status(NamedTuple):
    """Of the detector."""

    health: Health
    figures: Mapping[str, str]


class VisionWatch:
    """A thread from begin() to end(). status: how the detector is, from any thread; None: not known yet."""

    def __init__(
        self,
        publisher: MakePublisher,
        eye: Eye,
        status: Callable[[], Status | None],
        camera: Intrinsics,
        config: BusConfig,
        stamper: Stamper,
        clock: Clock,
    ) -> None:
        self._eye, self._status, self._camera = eye, status, camera
        self._quality, self._stamper, self._clock = config.jpeg_quality, stamper, clock
        self._image = publisher(topics.IMAGE, config.image_hz)
        # With every frame: on a beat of its own, who pairs them by their stamps would find none for an image.
        self._info = publisher(topics.CAMERA_INFO, ALL_HZ)
        self._diagnostics = publisher(topics.DIAGNOSTICS, ALL_HZ)
        self._change = OnChange(round(1e9 / config.state_hz))
        self._frame_ns = 0
        self._wake, self._ending, self._failed = Wake(), False, False
        self._thread = threading.Thread(target=self._run, name="vision's states and images", daemon=True)

    def begin(self) -> None:
        """Starts the thread."""
        self._thread.start()

    def end(self, timeout_s: float) -> None:
        """Waits so long at most for its end."""
        self._ending = True
        self._wake()
        join(self._thread, timeout_s)

    def _run(self) -> None:
        while not self._ending:
            self._wake.wait(TURN_S)
            try:
                self.tell()
            except Exception:
                if not self._failed:
                    log.exception("states and images: cannot be told; said once")
                self._failed = True

    def tell(self) -> None:
        """What is due now."""
        now_ns = self._clock()
        self._tell_states(now_ns)
        frames = self._eye.after(self._frame_ns)
        if not frames:
            return
        frame = frames[-1]
        self._frame_ns = frame.stamp_ns
        if self._image.wanted(now_ns):
            self._image.put(from_image(frame, self._stamper, self._quality), frame.stamp_ns)
        if self._info.wanted(now_ns):
            self._info.put(from_camera_info(frame.stamp_ns, self._camera, self._stamper), frame.stamp_ns)

    def _tell_states(self, now_ns: int) -> None:
        status = self._status()
        healths: Tuple[Health, ...] = (self._eye.health,) if status is None else (self._eye.health, status.health)
        if self._change.due(now_ns, healths) and self._diagnostics.wanted(now_ns):
            figures = {} if status is None else {status.health.component: status.figures}
            self._diagnostics.put(from_healths(now_ns, healths, self._stamper, figures), now_ns)
