# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A Pioneer's driver on a virtual line, as the tests need it."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Optional

import pytest

from edgefusion.clock import SimClock
from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import PacketFinder
from edgefusion.types import Twist2D
from scripted_pioneer import ScriptedPioneer
from virtual_port import VirtualLine


class Scene:
    """driver: on robot, over line; time passes by what the driver waits for."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, robot: ScriptedPioneer, config: PioneerConfig):
        self.clock, self.robot = SimClock(10**9), robot
        self.line = VirtualLine(robot, self.clock)
        self.line.serve(monkeypatch)
        self.link = Link("/dev/ttyROBOT", 9600, lock_folder=folder, clock=self.clock)
        self.driver = Pioneer(self.link, config, BaseConfig(), self.clock, self.line.pause)

    def started(self) -> Scene:
        self.driver.start()
        return self

    def run(self, seconds: float, twist: Optional[Twist2D] = None) -> list[RobotState]:
        """Polls for so long, commanding twenty times a second where there is a velocity."""
        states: list[RobotState] = []
        end_ns, drive_ns = self.clock() + round(seconds * 1e9), self.clock()
        while self.clock() < end_ns:
            if twist is not None and self.clock() >= drive_ns:
                self.driver.drive(twist)
                drive_ns += 50_000_000
            states += self.driver.poll()
        return states

    def told(self, number: Command) -> list[Optional[int]]:
        """The arguments of a command, as the robot understood them."""
        return [argument for told, argument in self.robot.told if told == number]


def packets(data: bytes) -> list[bytes]:
    """The bodies of what was written."""
    return [packet.body for packet in PacketFinder().feed(data)]


def last_words(made: Scene) -> list[int]:
    """The commands of what was written last."""
    return [body[0] for body in packets(made.line.written[-1][1])]


MakeScene = Callable[..., Scene]


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    made: list[Scene] = []

    def make(robot: Optional[ScriptedPioneer] = None, **settings: object) -> Scene:
        made.append(Scene(tmp_path, monkeypatch, robot or ScriptedPioneer(), PioneerConfig(**settings)))
        return made[-1]

    yield make
    for each in made:
        each.driver.close()
