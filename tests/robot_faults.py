# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated Pioneer that is driven as the base drives it, in a time of its own, while something goes wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Callable

import numpy as np
import pytest

from edgefusion.config import PioneerConfig
from edgefusion.drivers.sip_command import Command
from edgefusion.service.device_thread import DeviceThread
from edgefusion.service.ending import Ending
from edgefusion.service.robot_device import RobotDevice
from edgefusion.types import HealthState, Twist2D
from pioneer_scenes import Scene, SimulatedPioneer

SEEDS = range(20)
MS, S = 1_000_000, 1_000_000_000
AHEAD = Twist2D(0.3)
ZEROS = {(Command.STOP, None), (Command.E_STOP, None), (Command.VEL, 0)}


class Driven(Scene):
    """A scene whose robot is owned as by the base's thread, but one turn at a time."""

    robot: SimulatedPioneer

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, seed: int = 0) -> None:
        super().__init__(folder, monkeypatch, SimulatedPioneer(), PioneerConfig())
        self.rng = np.random.default_rng(seed)
        self.device = RobotDevice(self.driver, self.clock)
        self.thread = DeviceThread(self.device, Ending(), lambda: None, self.clock, self.line.pause)

    @property
    def is_lost(self) -> bool:
        """As the base hears it: there is no newest report."""
        return self.thread.news.newest is None

    @property
    def has_failed(self) -> bool:
        return self.thread.news.health.state is HealthState.FAILED

    def until(self, done: Callable[[], bool], within_s: float, twist: Twist2D | None = None) -> float:
        """Turns until something is so, commanding in every one as long as there is a report; how long that took [s]."""
        begun_ns = self.clock()
        while not done():
            assert self.clock() - begun_ns <= within_s * S, "it did not come to it"
            report = self.thread.news.newest
            if twist is not None and report is not None:
                self.device.drive(self.clock(), twist, report.session)
            self.thread.turn()
        return (self.clock() - begun_ns) / S

    def for_s(self, seconds: float, twist: Twist2D | None = None) -> None:
        end_ns = self.clock() + round(seconds * S)
        self.until(lambda: self.clock() >= end_ns, seconds + 10, twist)

    def drives(self) -> Driven:
        """Started, and at its speed for a random while."""
        self.until(lambda: not self.is_lost, 5)
        self.for_s(1.3 + 0.3 * self.rng.random(), AHEAD)
        assert self.robot.body.twist.v_mps == pytest.approx(AHEAD.v_mps, abs=0.01)
        return self

    def told_since(self, ns: int, number: Command) -> list[int | None]:
        """The arguments of a command."""
        heard = self.robot.firmware.heard
        return [told.argument for then_ns, told in heard if then_ns > ns and told.number == number]

    def moved_since(self, ns: int) -> list[tuple[int, int | None]]:
        """What the robot was told since then that would move it."""
        moving = (Command.VEL, Command.RVEL, Command.VEL2, Command.HEAD, Command.DHEAD)
        heard = [(told.number, told.argument) for then_ns, told in self.robot.firmware.heard if then_ns > ns]
        return [(number, argument) for number, argument in heard if number in moving and argument]

    def stopped_after_s(self, injected_ns: int) -> float:
        """T0: until the first zero that the robot heard."""
        for ns, told in self.robot.firmware.heard:
            if ns >= injected_ns and (told.number, told.argument) in ZEROS:
                return (ns - injected_ns) / S
        raise AssertionError("it was not told to stop")


MakeDriven = Callable[[int], Driven]


@pytest.fixture
def driven(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    made: list[Driven] = []

    def make(seed: int) -> Driven:
        made.append(Driven(tmp_path, monkeypatch, seed))
        return made[-1].drives()

    yield make
    for each in made:
        each.driver.close()
