# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of a camera with which something is wrong: the figures C1 to C3, in virtual time.

C4, a read that hangs, is a matter of processes: tests/test_camera.py and `make faults`.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from edgefusion.config import CameraConfig
from edgefusion.drivers.camera_state import CameraState
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.live_camera import Picture
from edgefusion.types import HealthState

MS = 1_000_000
SEEDS = range(20)


class Watched:
    """A camera of 20 pictures a second, and what is told of it."""

    def __init__(self, seed: int, fault: str) -> None:
        self._rng = np.random.default_rng(seed)
        self._scene = self._rng.integers(0, 256, (48, 64, 3), np.uint8)
        self.begin_ns = int(self._rng.integers(1000, 3000)) * MS
        self._next_ns = int(self._rng.integers(50)) * MS
        self._faulty = FaultyPictures(parse_fault(f"{fault}@{self.begin_ns / 1e9}+5"), self._rng, 0)
        self.state, self.now_ns = CameraState(CameraConfig()), 0

    def _picture(self) -> Picture:
        noise = self._rng.normal(0, 3, self._scene.shape)
        noisy = np.clip(self._scene + noise, 0, 255).astype(np.uint8)
        return Picture(self.now_ns, cv2.imencode(".jpg", noisy)[1].tobytes())

    def run_to(self, ns: int) -> None:
        while self.now_ns < ns:
            self.now_ns += MS
            made = None
            if self.now_ns >= self._next_ns:
                made, self._next_ns = self._picture(), self._next_ns + 50 * MS
            for sent in self._faulty.sent(made, self.now_ns):
                self.state.take(self.now_ns, cv2.imdecode(np.frombuffer(sent.jpeg, np.uint8), cv2.IMREAD_COLOR))

    def told_after_s(self, code: str) -> float:
        """From the fault's begin until the health names it [s]."""
        self.run_to(self.begin_ns)
        assert self.state.health(self.now_ns).state is HealthState.OK
        while not self.state.health(self.now_ns).reason.startswith(code):
            self.run_to(self.now_ns + 5 * MS)
            assert self.now_ns < self.begin_ns + 4000 * MS
        return (self.now_ns - self.begin_ns) / 1e9


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("fault", "code", "limit_s"),
    [
        ("camera=off", "CAMERA_LOST", 0.5),
        ("camera=stuck", "CAMERA_FROZEN", 1.0),
        ("camera=wrong", "CAMERA_BLIND", 1.0),
    ],
    ids=["c1-unplugged", "c2-frozen", "c3-covered"],
)
def test_it_is_told_in_time_and_well_again_when_it_is(seed: int, fault: str, code: str, limit_s: float) -> None:
    watched = Watched(seed, fault)
    assert watched.told_after_s(code) <= limit_s
    watched.run_to(watched.begin_ns + 5500 * MS)
    assert watched.state.health(watched.now_ns).state is HealthState.OK
