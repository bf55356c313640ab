# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base's loop that drives a simulated base with a laser through a room, in simulated time, with anything broken."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from edgefusion.config import BaseConfig, Config, MissionConfig
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.pose_history import PoseHistory
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.robot_device import RobotReport
from edgefusion.sim.plan_simulation import PlanSimulation, PlanSpec
from edgefusion.types import Goal, Health, HealthState, Pose2D, Scan, Twist2D

S, MS = 1_000_000_000, 1_000_000
TICK_NS, REPORT_NS = 50 * MS, 100 * MS
CONFIG = Config(mission=MissionConfig(interest=()))
ROOM = np.array([[-2, -2, 4, -2], [4, -2, 4, 2], [4, 2, -2, 2], [-2, 2, -2, -2]], float)
AHEAD = Goal("ahead", Pose2D(1.0, 0.0))
WELL = {name: Health(name, HealthState.OK) for name in ("robot", "laser")}


def failed(name: str, reason: str = "lost") -> Health:
    return Health(name, HealthState.FAILED, reason)


def room(base: BaseConfig = CONFIG.base) -> PlanSimulation:
    return PlanSimulation(ROOM, Pose2D(), PlanSpec(base.footprint_m, laser_pose=Pose2D(*base.laser_pose)))


@dataclass
class Bench:
    """Steps a loop 20 times a second. healths: as the devices report them; failures: as DeviceNews counts them; others:
    the supervisor's healths; mute: devices of which nothing comes, though they do not know it; changes: to every report
    of the robot; truth: where the robot was at every tick."""

    loop: BaseLoop = field(default_factory=lambda: BaseLoop(CONFIG))
    simulation: PlanSimulation = field(default_factory=room)
    healths: dict = field(default_factory=lambda: dict(WELL))
    failures: dict = field(default_factory=lambda: {"robot": (0, ""), "laser": (0, "")})
    others: tuple = ()
    mute: set = field(default_factory=set)
    changes: dict = field(default_factory=dict)
    outputs: list = field(default_factory=list)
    truth: PoseHistory = field(default_factory=lambda: PoseHistory(60 * S))
    _report: RobotReport | None = None
    _scan: Scan | None = None

    def tick(self, after_ns: int = TICK_NS) -> Outputs:
        simulation = self.simulation
        simulation.step_to(simulation.stamp_ns + after_ns)
        if after_ns:
            self.truth.add(simulation.stamp_ns, simulation.pose)
        if "laser" not in self.mute:
            self._scan = simulation.newest_scan()
        if "robot" not in self.mute and simulation.stamp_ns % REPORT_NS == 0:
            self._report = RobotReport(self._state(), np.zeros((0, 2)), 1)
        inputs = Inputs(self._news("robot", self._report), self._news("laser", self._scan), healths=self.others)
        outputs = self.loop.step(simulation.stamp_ns, inputs)
        self.outputs.append(outputs)
        simulation.command(outputs.command)
        return outputs

    def run(self, seconds: float) -> list[Outputs]:
        return [self.tick() for _ in range(round(seconds * S / TICK_NS))]

    def fail(self, name: str, reason: str = "lost") -> None:
        """As its thread reports it from now on."""
        self.healths[name] = failed(name, reason)
        self.failures[name] = (self.failures[name][0] + 1, reason)

    def mend(self, name: str) -> None:
        self.healths[name] = WELL[name]

    def _news(self, name: str, newest: RobotReport | Scan | None) -> DeviceNews:
        return DeviceNews(self.healths[name], newest, self.simulation.stamp_ns, *self.failures[name])

    def _state(self) -> RobotState:
        simulation = self.simulation
        state = RobotState(
            simulation.stamp_ns, simulation.odometry, simulation.twist, 12.6, True, False, False, False, (False,) * 5,
            (False,) * 5,
        )  # fmt: skip
        return replace(state, **self.changes)


def driving(goal: Goal = AHEAD, seconds: float = 2.0) -> Bench:
    """A bench whose robot is on its way."""
    bench = Bench()
    bench.run(1)
    bench.loop.goto([goal])
    bench.run(seconds)
    assert bench.outputs[-1].command.v_mps > 0.2
    return bench


def stands(outputs: list[Outputs]) -> bool:
    return {each.command for each in outputs} == {Twist2D()}
