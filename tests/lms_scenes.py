# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""An LMS2xx's driver on the simulated scanner, over a virtual line, in a room in which the robot turns."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

from edgefusion.clock import SimClock
from edgefusion.config import LaserConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.pose_history import PoseHistory
from edgefusion.sim.fault_frames import LMS
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.types import Pose2D, Scan
from virtual_port import VirtualLine

S = 1_000_000_000
CORNERS = [(4, -3), (4, 3.5), (-3, 3.5), (-3, -3)]
ROOM = np.array([[*a, *b] for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1])], float)
EXACT = LaserSpec(sigma_m=0.0, dropped=0.0, mixed=0.0)
LIVELY = LaserSpec(sigma_m=0.003, dropped=0.0, mixed=0.0)
"""No two of its scans are the same, and all are true within 2 cm."""


class Scene:
    """driver: on scanner, over line. turn_radps: of the robot, in whose middle the laser is. step_ns: of the clock."""

    def __init__(
        self,
        folder: Path,
        monkeypatch: pytest.MonkeyPatch,
        config: LaserConfig | None = None,
        turn_radps: float = 0.0,
        real: LaserSpec = LIVELY,
        step_ns: int = 2_000_000,
        **scanner: Any,
    ) -> None:
        self.clock, self.turn_radps, self._rng = SimClock(5 * S), turn_radps, np.random.default_rng(1)
        self.scanner = LmsScanner(self.scan_at, self.clock(), real=real, **scanner)
        self.line = VirtualLine(self.scanner, self.clock, step_ns)
        self.line.serve(monkeypatch)
        self.link = Link("/dev/ttyLASER", 9600, lock_folder=folder, clock=self.clock)
        self.driver = Lms2xx(self.link, config or LaserConfig(), self.clock, self.line.pause)

    def pose_at(self, ns: int) -> Pose2D:
        return Pose2D(0.2, -0.1, math.remainder(self.turn_radps * (ns - 5 * S) / S, 2 * math.pi))

    def scan_at(self, stamp_ns: int, spec: LaserSpec) -> Scan:
        return SimLaser(spec).scan(stamp_ns, ROOM, self.pose_at, self._rng)[0]

    def truth(self, stamp_ns: int) -> Scan:
        """What a laser that measures all its beams at once would have seen then."""
        return SimLaser(replace(EXACT, turn_ns=0)).scan(stamp_ns, ROOM, self.pose_at, self._rng)[0]

    def history(self, scan: Scan) -> PoseHistory:
        """The poses around a scan."""
        poses = PoseHistory()
        for ms in range(-50, 51, 10):
            poses.add(scan.stamp_ns + ms * 1_000_000, self.pose_at(scan.stamp_ns + ms * 1_000_000))
        return poses

    def inject(self, fault: str) -> None:
        self.line.device = FaultyWire(self.scanner, LMS, parse_fault(fault), self._rng, self.clock())

    def mend(self) -> None:
        self.line.device = self.scanner

    def started(self) -> Scene:
        self.driver.start()
        return self

    def read(self, seconds: float, moving: bool = False) -> list[Scan]:
        """What came meanwhile."""
        scans, end_ns = [], self.clock() + round(seconds * S)
        while self.clock() < end_ns:
            scans += self.driver.read(moving)
        return scans

    def elapsed_s(self, since_ns: int) -> float:
        return (self.clock() - since_ns) / S


MakeScene = Callable[..., Scene]


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Makes a scene: scene(config, turn_radps, ...)."""
    made: list[Scene] = []

    def make(*args: Any, **settings: Any) -> Scene:
        made.append(Scene(tmp_path, monkeypatch, *args, **settings))
        return made[-1]

    yield make
    for each in made:
        each.driver.close()
