# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A Pioneer's driver on a virtual line, as the tests need it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Optional

import pytest

from edgefusion.clock import SimClock
from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import PacketFinder
from edgefusion.sim.floor_body import FloorBody
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import SH, Character
from edgefusion.sim.wire_line import PacedLine
from edgefusion.types import Twist2D
from scripted_pioneer import ScriptedPioneer
from virtual_port import VirtualLine

BODY_STEP_NS = 10_000_000


class SimulatedPioneer:
    """The simulated firmware as a wire device, on a floor whose time goes on with the line's. said: all its bytes."""

    def __init__(self, character: Character = SH) -> None:
        self.body = FloorBody()
        self.firmware = SipRobot(self.body, character)
        self.said = bytearray()
        self._now_ns = 0

    @property
    def line(self) -> PacedLine:
        return self.firmware.line

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        self._pass(now_ns)
        self.firmware.receive(data, baudrate, now_ns)

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        self._pass(now_ns)
        data = self.firmware.transmit(baudrate, now_ns)
        self.said += data
        return data

    def _pass(self, now_ns: int) -> None:
        if now_ns >= self._now_ns + BODY_STEP_NS:
            self.body.base.step(now_ns - self._now_ns)
            self._now_ns = now_ns


class Scene:
    """driver: on robot, over line; time passes by what the driver waits for."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, robot: Any, config: PioneerConfig):
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

    def make(robot: Any = None, **settings: object) -> Scene:
        made.append(Scene(tmp_path, monkeypatch, robot or ScriptedPioneer(), PioneerConfig(**settings)))
        return made[-1]

    yield make
    for each in made:
        each.driver.close()
