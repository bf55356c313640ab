# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of a robot that an operator drives when the velocities end, are none, or too fast: Z3 and Z4.

In virtual time, without processes; Z4 from the bus on, through the inbox, the helm and the gate.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from typing import List

import pytest
from virtual_base import VirtualBase

from base_scenes import AHEAD, CONFIG, MS, TICK_NS, Bench, S, stands
from bus_lab import Lab, until
from edgefusion.bus.arbiter import Arbiter
from edgefusion.bus.freshness import Freshness, Refusal, limits_of
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.publisher import CommandPublisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL
from edgefusion.config import BusConfig
from edgefusion.messages.geometry_msgs import Twist, Vector3
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.helm import Helm
from edgefusion.types import Twist2D

SEEDS = range(int(os.environ.get("EDGEFUSION_FAULT_SEEDS", "3")))
DEADMAN_NS = round(BusConfig().cmd_vel_timeout_s * S)
PERIOD_NS = 100 * MS
CALM = Twist2D(0.1)


class DrivenInAHall:
    """A base with its drivers that is driven ten times a second; the last velocity comes at `last_ns`."""

    def __init__(self, base: VirtualBase) -> None:
        self._base, self._helm = base, Helm(base.loop, Arbiter(DEADMAN_NS))
        base.run(8.0, base.well)
        base.run(0.5)
        begin_ns = base.clock() + int(base.rng.integers(PERIOD_NS))
        self._said_ns = [begin_ns + number * PERIOD_NS for number in range(8 + int(base.rng.integers(3)))]
        self.last_ns = self._said_ns[-1]
        self._step, base.loop.step = base.loop.step, self._driven

    def _driven(self, now_ns, inputs) -> Outputs:
        while self._said_ns and self._said_ns[0] <= now_ns:
            self._helm.cmd_vel(self._said_ns.pop(0), CALM)
        return self._step(now_ns, replace(inputs, twist=self._helm.twist(now_ns)))


@pytest.mark.parametrize("seed", SEEDS)
def test_z3_velocities_that_end_stop_the_robot_within_300_ms_which_then_stays(base, seed: int) -> None:
    robot = base(seed)
    driven = DrivenInAHall(robot)
    robot.run(10.0, lambda: robot.clock() >= driven.last_ns)
    assert robot.world.body.twist.v_mps > 0.05
    assert robot.stopped_after_s(driven.last_ns) <= 0.3
    assert robot.moved_m(0.5) == 0.0


class Driven(Bench):
    """A robot that is well, and an operator who drives it over the bus."""

    def __init__(self, lab: Lab) -> None:
        super().__init__()
        self._helm = Helm(self.loop, Arbiter(DEADMAN_NS))
        self.inbox = Inbox(
            lab.member(), "robot", CMD_VEL, to_cmd_vel, Freshness(limits_of(lab.config)), lambda: self.now_ns
        )
        self._operator = CommandPublisher(lab.client(), "robot", CMD_VEL, Tagger(), 200)
        until(lambda: self._operator.heard)
        step = self.loop.step
        self.loop.step = lambda now_ns, inputs: step(now_ns, replace(inputs, twist=self._twist(now_ns)))
        self.run(1)

    @property
    def now_ns(self) -> int:
        return self.simulation.stamp_ns

    @property
    def refused(self) -> dict[Refusal, int]:
        return dict(self.inbox.freshness.counts)

    def _twist(self, now_ns: int) -> Twist2D | None:
        for received_ns, twist in self.inbox.take(now_ns):
            self._helm.cmd_vel(received_ns, twist)
        return self._helm.twist(now_ns)

    def say(self, v_mps: float, w_radps: float = 0.0) -> Outputs:
        """What the next cycle makes of it."""
        self._operator.put(Twist(Vector3(x=v_mps), Vector3(z=w_radps)))
        until(lambda: self.inbox.waiting)
        return self.tick()

    def drive(self, twist: Twist2D, seconds: float) -> List[Outputs]:
        return [self.say(twist.v_mps, twist.w_radps) for _ in range(round(seconds * S / TICK_NS))]


@pytest.fixture
def driven(lab: Lab) -> Driven:
    return Driven(lab)


@pytest.mark.parametrize("said", [(math.nan, 0.0), (math.inf, 0.0), (0.1, math.nan), (0.1, -math.inf)])
def test_z4_a_velocity_that_is_none_is_refused_and_counted_and_the_motion_is_unchanged(
    driven: Driven, said: tuple[float, float]
) -> None:
    driven.drive(CALM, 0.5)
    assert [driven.say(*said).command for _ in range(3)] == [CALM] * 3
    assert driven.refused == {Refusal.MALFORMED: 3}
    assert stands(driven.run(0.5)[1:])  # it is no velocity that keeps the robot driving, either


def test_z4_velocities_that_are_none_do_not_take_the_robot_from_its_mission(driven: Driven) -> None:
    driven.loop.goto([AHEAD])
    driven.run(1.5)
    outputs = [driven.say(none) for none in (math.nan, math.inf, -math.inf)]
    assert all(each.command.v_mps > 0.2 and not each.paused for each in outputs)
    assert driven.refused == {Refusal.MALFORMED: 3}


@pytest.mark.parametrize("twist", [Twist2D(0.51), Twist2D(-30.0), Twist2D(1e300), Twist2D(0.1, -1e300)])
def test_z4_a_velocity_over_the_limit_is_driven_at_the_limit_and_counted(driven: Driven, twist: Twist2D) -> None:
    driven.drive(CALM, 0.2)
    assert driven.loop.over_limit == 0
    outputs = driven.drive(twist, 0.5)
    assert driven.loop.over_limit == len(outputs)
    assert driven.refused == {}
    for command in (each.command for each in outputs):
        assert abs(command.v_mps) <= CONFIG.base.max_speed_mps
        assert abs(command.w_radps) <= CONFIG.base.max_yaw_rate_radps
        assert command != Twist2D()
