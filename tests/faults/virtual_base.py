# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base with robot and laser in one room, in virtual time: real drivers, loop and gate, simulated firmware and world.

Its threads take turns here: the laser's goes on all the time, and while it waits for anything, which is most of the
time, the robot's and the loop get theirs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np

from base_lab import ROOM
from edgefusion.clock import SimClock
from edgefusion.config import Config, LaserConfig
from edgefusion.drivers import link
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.drivers.lms2xx_setup import configured_age_limit_s
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.sip_command import Command
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.laser_device import LaserDevice
from edgefusion.service.robot_device import RobotDevice
from edgefusion.sim.fault_frames import LMS, SIP
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.live_world import LiveWorld
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.wire_device import WireDevice
from edgefusion.types import Goal, Health, HealthState, Pose2D, Scan, Twist2D
from virtual_port import VirtualLine

S = 1_000_000_000
CYCLE_NS = 50_000_000
FAR = Goal("far", Pose2D(3.0, 0.0), 0.05, math.pi)


class _SharedClock(SimClock):
    """While somebody waits, the others get their turns."""

    others: Callable[[], None] | None = None

    def advance(self, ns: int) -> int:
        now_ns = super().advance(ns)
        if self.others is not None:
            others, self.others = self.others, None
            try:
                others()
            finally:
                self.others = others
        return now_ns


class _InTime:
    """A device whose world has come as far as its line."""

    def __init__(self, device: WireDevice, world: LiveWorld) -> None:
        self._device, self._world = device, world
        self.line = device.line

    def receive(self, data: bytes, baudrate: int | None, now_ns: int) -> None:
        self._world.step_to(now_ns)
        self._device.receive(data, baudrate, now_ns)

    def transmit(self, baudrate: int | None, now_ns: int) -> bytes:
        self._world.step_to(now_ns)
        return self._device.transmit(baudrate, now_ns)


@dataclass
class Turn:
    """What a device's thread does, when it is its turn. retry_ns: when a lost one is tried again."""

    device: Any
    news: DeviceNews[Any]
    clock: SimClock
    retry_ns: int = 0
    started: bool = False
    failures: int = 0
    losses: list[tuple[int, str]] = field(default_factory=list)

    def take(self) -> None:
        try:
            if not self.started:
                if self.clock() < self.retry_ns:
                    self.clock.advance(5_000_000)
                    return
                self.device.start()
                self.started = True
            self._note(list(self.device.poll()))
        except LinkError as error:
            self.started, self.retry_ns = False, self.clock() + S // 20
            self.losses.append((self.clock(), str(error)))
            self._note([], lost=True)

    def _note(self, came: list[Any], lost: bool = False) -> None:
        health: Health = self.device.health
        failed = health.state is HealthState.FAILED
        self.failures += failed and self.news.health.state is not HealthState.FAILED
        newest = None if lost else (came[-1] if came else self.news.newest)
        at_ns = self.clock() if came else self.news.received_ns
        self.news = DeviceNews(health, newest, at_ns, self.failures, health.reason if failed else self.news.failure)


class VirtualBase:
    """baudrate: the laser's. seed: of all noise, and of when in its periods everything is."""

    def __init__(self, monkeypatch: Any, seed: int = 0, baudrate: int = 500000) -> None:
        self.rng = np.random.default_rng(seed)
        self.clock = _SharedClock(int(self.rng.integers(S, 2 * S)))
        self.world = LiveWorld(ROOM, self.clock(), seed)
        self.scan_delay_s = 0.0
        self.robot, self.scanner = self._firmware()
        self.lines = {
            "robot": VirtualLine(_InTime(self.robot, self.world), self.clock),
            "laser": VirtualLine(_InTime(self.scanner, self.world), self.clock),
        }
        monkeypatch.setattr(link, "open_port", lambda name, speed: self.lines[name].open(name, speed))
        self.config = Config(laser=LaserConfig(baudrate=baudrate))
        self.age_limit_s = configured_age_limit_s(self.config.laser)
        self.loop = BaseLoop(self.config, self.age_limit_s)
        self._turns(monkeypatch)
        self._next_ns, self.outputs = self.clock(), []
        self._robot_ns = 0
        self._held: list[Scan] = []

    def _firmware(self) -> tuple[SipRobot, LmsScanner]:
        now_ns = self.clock()
        return SipRobot(self.world.body, now_ns=now_ns), LmsScanner(self.world.scan_at, now_ns)

    def _turns(self, monkeypatch: Any) -> None:
        def line(name: str, baudrate: int) -> Link:
            return Link(name, baudrate, clock=self.clock, lock_folder=self._locks)

        pause = self.lines["robot"].pause
        self._locks = monkeypatch.locks
        pioneer = Pioneer(line("robot", 9600), self.config.robot, self.config.base, self.clock, pause)
        lms = Lms2xx(line("laser", 9600), self.config.laser, self.clock, pause)
        starting = HealthState.STARTING
        self.device = RobotDevice(pioneer, self.clock)
        self.robot_turn = Turn(self.device, DeviceNews(Health("robot", starting, "not started")), self.clock)
        laser = LaserDevice(lms, self._moves)
        self.laser_turn = Turn(laser, DeviceNews(Health("laser", starting, "not started")), self.clock)

    def _moves(self) -> bool:
        report = self.robot_turn.news.newest
        return report is not None and report.state.twist != Twist2D()

    def inject(self, fault: str) -> int:
        """From now on: as `laser=off`. Returns now."""
        wanted = parse_fault(fault)
        protocol = LMS if wanted.component == "laser" else SIP
        line = self.lines[wanted.component]
        line.device = FaultyWire(line.device, protocol, wanted, self.rng, self.clock())
        return self.clock()

    def mend(self, component: str) -> None:
        """What was injected is gone."""
        device = self.scanner if component == "laser" else self.robot
        self.lines[component].device = _InTime(device, self.world)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> list[Outputs]:
        """What the loop put out meanwhile."""
        end_ns, begin = self.clock() + round(seconds * S), len(self.outputs)
        self.clock.others = self._others
        try:
            while self.clock() < end_ns and not until():
                self.laser_turn.take()
        finally:
            self.clock.others = None
        return self.outputs[begin:]

    def _others(self) -> None:
        if self.clock() >= self._robot_ns:
            self.robot_turn.take()
            self._robot_ns = self.clock()
        if self.clock() >= self._next_ns:
            self._next_ns += CYCLE_NS * (1 + (self.clock() - self._next_ns) // CYCLE_NS)
            self._step()

    def _step(self) -> None:
        outputs = self.loop.step(self.clock(), Inputs(self.robot_turn.news, self._laser_news()))
        if outputs.enable_motors:
            self.device.enable_motors()
        if outputs.session is not None:
            self.device.drive(outputs.stamp_ns, outputs.command, outputs.session)
        self.outputs.append(outputs)

    def _laser_news(self) -> DeviceNews[Scan]:
        """Late by scan_delay_s, behind the driver's stamp."""
        news = self.laser_turn.news
        if not self.scan_delay_s:
            return news
        if news.newest is not None and (not self._held or self._held[-1] is not news.newest):
            self._held.append(news.newest)
        due = [scan for scan in self._held if scan.stamp_ns + self.scan_delay_s * 1e9 <= self.clock()]
        return DeviceNews(news.health, due[-1] if due else None, news.received_ns, news.failures, news.failure)

    def driving(self) -> VirtualBase:
        """The same, at speed towards a goal."""
        self.run(8.0, lambda: bool(self.outputs) and not self.outputs[-1].decision.findings[1:] and self.well())
        self.run(0.5)
        self.loop.goto([FAR])
        self.run(5.0, lambda: self.world.body.twist.v_mps > 0.35)
        assert self.world.body.twist.v_mps > 0.35
        self.run(float(self.rng.uniform(0.0, 0.3)))
        return self

    def well(self) -> bool:
        healths = self.robot_turn.news.health, self.laser_turn.news.health
        return all(health.state is HealthState.OK for health in healths) and self.laser_turn.news.newest is not None

    def stopped_after_s(self, since_ns: int, within_s: float = 3.0) -> float:
        """From then until the robot was first told to stand [s]; inf where it was not."""
        told: list[int] = []

        def zero() -> bool:
            told[:] = [ns for ns, command in self.robot.heard if ns >= since_ns and _stops(command)]
            return bool(told)

        self.run(within_s, zero)
        return (told[0] - since_ns) / S if told else math.inf

    def moved_m(self, seconds: float) -> float:
        """How far it gets in a while, once it has come to rest."""
        self.run(2.5)
        before = self.world.body.pose
        self.run(seconds)
        after = self.world.body.pose
        return math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)


def _stops(command: Any) -> bool:
    if command.number in (Command.STOP, Command.E_STOP, Command.CLOSE):
        return True
    return command.number == Command.VEL and command.value == 0
