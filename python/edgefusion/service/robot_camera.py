# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A camera at another computer than the robot's, with its frames stamped by the robot's clock."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import replace
from typing import List

from edgefusion.service.robot_clock import RobotClock
from edgefusion.service.vision_eye import CameraDriver
from edgefusion.types import Frame, Health

_KEPT = 256
_SLACK_NS = 500_000_000
"""Readings of the robot's clock differ by less."""


class RobotCamera:
    """As the camera. A frame keeps its stamp when the clock is known better: nobody sees it twice."""

    def __init__(self, camera: CameraDriver, clock: RobotClock) -> None:
        self._camera, self._clock = camera, clock
        self._stamps: OrderedDict[int, int] = OrderedDict()
        self._lock = threading.Lock()

    def health(self) -> Health:
        return self._camera.health()

    def latest(self, max_age_s: float) -> Frame:
        return self._stamped(self._camera.latest(max_age_s))

    def after(self, stamp_ns: int) -> List[Frame]:
        frames = map(self._stamped, self._camera.after(self._clock.own(stamp_ns) - _SLACK_NS))
        return [frame for frame in frames if frame.stamp_ns > stamp_ns]

    def _stamped(self, frame: Frame) -> Frame:
        with self._lock:
            stamp_ns = self._stamps.setdefault(frame.stamp_ns, self._clock.of(frame.stamp_ns))
            if len(self._stamps) > _KEPT:
                self._stamps.popitem(last=False)
        return replace(frame, stamp_ns=stamp_ns)
