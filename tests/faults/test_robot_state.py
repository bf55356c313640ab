# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""R4, R7, R8: a robot that starts anew, does not do what it is told, or says that it must not be driven."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Callable

import pytest

from edgefusion.config import Config
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.service.base_inputs import Inputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.device_news import DeviceNews
from edgefusion.sim.fault_frames import SIP
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import Fault
from edgefusion.types import Goal, Health, HealthState, Pose2D, Twist2D
from robot_faults import AHEAD, SEEDS, Driven, MakeDriven, driven

__all__ = ["driven"]
PRESSED = (False, True, False, False, False), (False,) * 5


def bump(made: Driven) -> None:
    made.robot.body.bumpers = PRESSED


def press(made: Driven) -> None:
    made.robot.firmware.e_stop_pressed = True


def switch_off(made: Driven) -> None:
    made.robot.firmware.drive.motors = False


UNWELL = [(bump, "bumped: front 2"), (press, "the emergency stop is pressed"), (switch_off, "the motors are off")]


@pytest.mark.parametrize("off_s", [0.5, 2.0])
@pytest.mark.parametrize("seed", SEEDS)
def test_r4_a_robot_that_starts_anew_is_found_with_its_motors_off_where_it_was(
    driven: MakeDriven, seed: int, off_s: float
) -> None:
    made = driven(seed)
    report = made.thread.news.newest
    assert report is not None
    before, injected_ns = report.state.odometry, made.clock()
    made.robot.firmware.power_cycle(injected_ns, off_s)
    made.until(lambda: made.is_lost, 1, AHEAD)
    assert made.until(lambda: not made.is_lost, 5, AHEAD) <= max(off_s - 0.2, 0) + 3.0
    made.for_s(1)
    report = made.thread.news.newest
    assert report is not None
    assert math.dist((report.state.odometry.x_m, report.state.odometry.y_m), (before.x_m, before.y_m)) <= 0.04
    assert not report.state.motors_enabled
    assert made.told_since(injected_ns, Command.ENABLE) == []
    assert made.moved_since(injected_ns + 300_000_000) == []


@pytest.mark.parametrize("seed", SEEDS)
def test_r7_wheels_that_are_blocked_and_say_so_stop_it(driven: MakeDriven, seed: int) -> None:
    made = driven(seed)
    made.robot.body.stalled = (True, True)
    injected_ns = made.clock()
    made.for_s(1.5, AHEAD)
    assert made.stopped_after_s(injected_ns) <= 0.15
    assert made.thread.news.health.reason == "both wheels stalled"


@pytest.mark.parametrize("starts", [False, True], ids=["moving", "from standstill"])
@pytest.mark.parametrize("seed", SEEDS)
def test_r7_wheels_that_do_not_turn_stop_it(
    driven: MakeDriven, seed: int, starts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = driven(seed)
    if starts:
        made.for_s(2.0, Twist2D())
    made.robot.body.halt()
    monkeypatch.setattr(made.robot.body, "command", lambda twist: None)
    injected_ns = made.clock()
    made.until(lambda: made.has_failed, 3, AHEAD)
    assert made.thread.news.health.reason == "the wheels do not do what they were told"
    assert made.stopped_after_s(injected_ns) <= 1.1


@pytest.mark.parametrize("seed", SEEDS)
def test_r7_reports_that_are_stuck_stop_it(driven: MakeDriven, seed: int) -> None:
    made = driven(seed)
    made.line.device = FaultyWire(made.robot, SIP, Fault("robot", "stuck", 0.0), made.rng, made.clock())
    injected_ns = made.clock()
    made.until(lambda: made.has_failed, 3, AHEAD)
    assert made.stopped_after_s(injected_ns) <= 1.1


@pytest.mark.parametrize(("happens", "reason"), UNWELL)
@pytest.mark.parametrize("seed", SEEDS)
def test_r8_what_it_reports_stops_it_within_a_cycle(
    driven: MakeDriven, seed: int, happens: Callable[[Driven], None], reason: str
) -> None:
    made = driven(seed)
    happens(made)
    injected_ns = made.clock()
    made.for_s(0.5, AHEAD)
    assert made.stopped_after_s(injected_ns) <= 0.15
    assert reason in made.thread.news.health.reason
    assert made.moved_since(injected_ns + 150_000_000) == []


@pytest.mark.parametrize(("happens", "reason"), UNWELL[:2])
def test_r8_at_boot_a_goal_is_refused_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, happens: Callable[[Driven], None], reason: str
) -> None:
    made = Driven(tmp_path, monkeypatch)
    happens(made)
    made.until(lambda: not made.is_lost, 5)
    loop = BaseLoop(Config())
    loop.step(made.clock(), Inputs(made.thread.news, DeviceNews(Health("laser", HealthState.OK))))
    with pytest.raises(RefusedError, match=reason):
        loop.goto([Goal("1", Pose2D(1.0, 0.0))])
    made.for_s(1.0, AHEAD)
    assert made.moved_since(0) == []
    made.driver.close()
