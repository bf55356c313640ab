# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of a camera with which something is wrong: the figures C1 to C4, in virtual time.

With its own process, over HTTP: tests/test_camera_server.py and `make faults`.
"""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import Deque

import cv2
import numpy as np
import pytest

from edgefusion.clock import SimClock
from edgefusion.config import CameraConfig
from edgefusion.drivers import camera_source
from edgefusion.drivers.camera_loop import CaptureLoop
from edgefusion.drivers.camera_pipe import PipeEndedError
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.live_camera import Picture
from edgefusion.types import HealthState

S = 1_000_000_000
TURN_NS = S // 100
PERIOD_NS = S // 20
SEEDS = range(20)
WELL = "camera=off@1000000"


class Reader:
    """Reads what comes while it is open; one that hangs gets nothing any more."""

    def __init__(self, world: Watched) -> None:
        self._world, self.hangs = world, False
        world.came.clear()

    def read(self, timeout_s: float) -> camera_source.Picture | None:
        if self._world.is_unplugged:
            raise PipeEndedError("no more pictures")
        if self.hangs or not self._world.came:
            return None
        arrival_ns, jpeg = self._world.came.popleft()
        image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise PipeEndedError("a picture that cannot be decoded")
        return camera_source.Picture(arrival_ns, image)

    def close(self) -> None:
        self.hangs = True


class Watched:
    """A camera of 20 pictures a second that was well for a while, and who looks at its newest picture all the time.

    given: the ages of the pictures that there were to look at.
    """

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._scene = self._rng.integers(0, 240, (48, 64, 3), np.uint8)
        self.clock, self.is_unplugged = SimClock(0), False
        self.came: Deque[tuple[int, bytes]] = deque()
        self.inject(WELL)
        self._due_ns = int(self._rng.integers(PERIOD_NS))
        self.loop = CaptureLoop(self._open, CameraConfig(), self.clock)
        self.given: list[float] = []
        self.run(0.5 + self._rng.random())
        assert self.is_well() and self.given

    def _open(self) -> Reader:
        if self.is_unplugged:
            raise PipeEndedError("not there")
        self.reader = Reader(self)
        return self.reader

    def inject(self, fault: str) -> None:
        self._faulty = FaultyPictures(parse_fault(fault), self._rng, self.clock())

    def turn(self) -> None:
        now_ns = self.clock.advance(TURN_NS)
        made = None
        if now_ns >= self._due_ns:
            self._due_ns += PERIOD_NS
            noisy = self._scene + self._rng.integers(0, 8, self._scene.shape, np.uint8)
            made = Picture(now_ns, cv2.imencode(".jpg", noisy)[1].tobytes())
        self.came.extend((now_ns, sent.jpeg) for sent in self._faulty.sent(made, now_ns))
        self.loop.step(0.0)
        with suppress(NoFrameError):
            self.given.append((now_ns - self.loop.latest(0.2).stamp_ns) / S)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * S / TURN_NS)):
            self.turn()

    def is_well(self) -> bool:
        return self.loop.health().state is HealthState.OK

    def after_s(self, holds) -> float:
        """How long until it is so [s]."""
        begin_ns = self.clock()
        while not holds():
            assert self.clock() - begin_ns < 20 * S
            self.turn()
        return (self.clock() - begin_ns) / S

    def told_after_s(self, code: str) -> float:
        """How long until that is what the health says [s]; nothing is to be looked at from then on."""
        seconds = self.after_s(lambda: self.loop.health().reason.startswith(code))
        before = len(self.given)
        self.run(0.7)
        assert len(self.given) == before and self.loop.health().reason.startswith(code)
        return seconds


@pytest.mark.parametrize("seed", SEEDS)
def test_c1_unplugged_it_is_lost_and_back_and_nothing_old_is_looked_at(seed: int) -> None:
    watched = Watched(seed)
    watched.is_unplugged = True
    assert watched.told_after_s("CAMERA_LOST") <= 0.5
    watched.is_unplugged = False
    assert watched.after_s(watched.is_well) <= 3.0
    assert max(watched.given) <= 0.2


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("fault", "code", "limit_s"),
    [
        ("camera=off", "CAMERA_LOST", 0.5),
        ("camera=stuck", "CAMERA_FROZEN", 1.0),
        ("camera=wrong", "CAMERA_BLIND: black", 1.0),
        ("camera=wrong:0.4", "CAMERA_BLIND: covered", 1.0),
        ("camera=wrong:1", "CAMERA_BLIND: white", 1.0),
    ],
    ids=["c1-silent", "c2-frozen", "c3-black", "c3-covered", "c3-white"],
)
def test_it_is_told_in_time_and_not_looked_at_until_well(seed: int, fault: str, code: str, limit_s: float) -> None:
    watched = Watched(seed)
    watched.inject(fault)
    assert watched.told_after_s(code) <= limit_s
    watched.inject(WELL)
    assert watched.after_s(watched.is_well) <= 3.0
    assert max(watched.given) <= 0.2


@pytest.mark.parametrize("seed", SEEDS)
def test_c4_a_reader_that_hangs_is_replaced_in_five_seconds(seed: int) -> None:
    watched = Watched(seed)
    hanging = watched.reader
    hanging.hangs = True
    assert watched.told_after_s("CAMERA_LOST") <= 0.5
    assert 0.7 + 0.5 + watched.after_s(watched.is_well) <= 5.0
    assert watched.reader is not hanging and max(watched.given) <= 0.2


@pytest.mark.parametrize("seed", SEEDS[:4])
@pytest.mark.parametrize("fault", ["camera=garbage:0.3", "camera=delayed:0.15", "camera=slow:3", "camera=intermittent"])
def test_whatever_comes_is_looked_at_while_it_is_young_and_it_is_well_again_afterwards(seed: int, fault: str) -> None:
    watched = Watched(seed)
    watched.inject(fault)
    watched.run(1.0)
    watched.inject(WELL)
    assert watched.after_s(watched.is_well) <= 3.0
    assert max(watched.given) <= 0.2
