# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The world that a robot drives in while others are measured: its devices on ptys, and what really happened in it."""

from __future__ import annotations

import time
from bisect import bisect_right
from typing import Callable, List

import numpy as np
import numpy.typing as npt

from edgefusion.config.navigation import P3DX_FOOTPRINT_M
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.hull import Hull, bounded
from edgefusion.sim.live_devices import LiveDevices, LiveSetup, Shown
from edgefusion.tools.drive_log import Moment

_PAUSE_S = 0.001
_NOTED_NS = 50_000_000


class LiveRun:
    """Nothing goes on in it but in until(). trail: where the base was, and where its wheels believe it to be, both in
    the world. touched: whether its bumpers ever felt something."""

    def __init__(self, setup: LiveSetup) -> None:
        self.setup, self.devices = setup, LiveDevices(setup, time.monotonic_ns())
        self.trail: List[Moment] = []
        self.touched = False
        self._shown: List[Shown] = []

    def close(self) -> None:
        self.devices.close()

    def until(self, holds: Callable[[], object], within_s: float) -> bool:
        """Lets the time pass until something is so; whether it came to that in time."""
        end_ns = time.monotonic_ns() + round(within_s * 1e9)
        while not holds():
            now_ns = time.monotonic_ns()
            if now_ns > end_ns:
                return False
            self.devices.pump(now_ns)
            self._note(now_ns)
            time.sleep(_PAUSE_S)
        return True

    def go_on(self, seconds: float) -> None:
        """Lets so much time pass."""
        self.until(lambda: False, seconds)

    def captured_ns(self, driver_ns: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """When the pictures were captured that a driver has stamped so: it stamps what was handed out last."""
        out_ns = [shown.out_ns for shown in self._shown]
        return np.array([self._shown[max(bisect_right(out_ns, ns) - 1, 0)].stamp_ns for ns in driver_ns.tolist()])

    def clearance_m(self) -> float:
        """The least on the way, from the hull to anything that the laser could see."""
        hull, walls = Hull(P3DX_FOOTPRINT_M), bounded(self.built().plan.segments)
        return min(hull.clearance_m(moment.pose, walls) for moment in self.trail)

    def built(self) -> BuiltWorld:
        return build(self.setup.world, self.devices.world.rig.laser_height_m)

    def _note(self, now_ns: int) -> None:
        body, shown = self.devices.world.body, self.devices.shown
        self.touched |= any(any(side) for side in body.bumpers)
        while shown:
            self._shown.append(shown.popleft())
        if not self.trail or now_ns - self.trail[-1].stamp_ns >= _NOTED_NS:
            believed = self.setup.world.start.compose(body.odometry)
            self.trail.append(Moment(now_ns, body.pose, believed))
