# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The base in real time: over the wires of simulated devices, in its own process, and with drivers that fail."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from contextlib import suppress
from typing import Callable, Sequence

import pytest

from base_lab import Lab, wait_for
from base_scenes import AHEAD, CONFIG
from edgefusion.config import Config, LaserConfig, MissionConfig
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.service.base import Base
from edgefusion.service.base_devices import open_base
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.ending import Ending
from edgefusion.types import Goal, Health, HealthState

FAST = Config(mission=MissionConfig(interest=()), laser=LaserConfig(baudrate=500000))
CHILD = """
import sys, threading, time
from collections import deque
from contextlib import suppress
from pathlib import Path
from edgefusion.config import Config, MissionConfig, LaserConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.mission_step import MissionState
from edgefusion.service.base_devices import open_base
from edgefusion.service.signals import ended_by_signals
from edgefusion.types import Goal, Pose2D

config = Config(mission=MissionConfig(interest=()), laser=LaserConfig(baudrate=500000))
newest = deque(maxlen=1)
base = open_base(config, sys.argv[1], sys.argv[2], newest.append, Path(sys.argv[3]))

def go():
    while True:  # a machine that is too busy has the goal given up
        if newest and newest[0].mission.state in (MissionState.IDLE, MissionState.STOPPED):
            with suppress(RefusedError, TimeoutError):
                base.goto([Goal("far", Pose2D(3.0, 0.0))])
                continue
            with suppress(RefusedError, TimeoutError):
                base.resume()  # a robot that was lost has its motors off
        time.sleep(0.05)

threading.Thread(target=go, daemon=True).start()
with ended_by_signals():
    base.run()
"""


class Running:
    """A base that runs beside the test; error: what its run raised. Ended at leaving."""

    def __init__(self, base: Base) -> None:
        self.base, self.error = base, None
        self.thread = threading.Thread(target=self._run)

    def __enter__(self) -> Running:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.base.end()
        self.thread.join()

    def _run(self) -> None:
        try:
            self.base.run()
        except Exception as error:
            self.error = error


def accepted(base: Base, goal: Goal = AHEAD) -> bool:
    try:
        base.goto([goal])
    except (RefusedError, TimeoutError):
        return False
    return True


def mission_to(goal: Goal, base: Base, outputs: Sequence[Outputs]) -> MissionStep | None:
    """How it is. Asks again where a machine that is too busy had the goal given up."""
    mission = outputs[-1].mission if outputs else None
    stands = mission is None or mission.state in (MissionState.IDLE, MissionState.STOPPED)
    if stands and not accepted(base, goal):
        with suppress(RefusedError, TimeoutError):
            base.resume()  # a robot that was lost has its motors off
    return mission


def arrived(base: Base, outputs: Sequence[Outputs]) -> bool:
    mission = mission_to(AHEAD, base, outputs)
    return mission is not None and mission.state is MissionState.ARRIVED


def answer(ask: Callable[[], object]) -> str:
    """Why it was refused; empty where it was done. Asks again where the loop of a machine that is too busy is late."""
    given: list[str] = []

    def answers() -> bool:
        try:
            ask()
        except TimeoutError:
            return False
        except RefusedError as error:
            given.append(str(error))
        else:
            given.append("")
        return True

    wait_for(answers)
    return given[0]


def assert_ended_by_a_stop(lab: Lab) -> None:
    *stop, close = [(number, value) for _, number, value in lab.motions()[-4:]]
    assert sorted(stop) == [(Command.VEL, 0), (Command.RVEL, 0), (Command.STOP, 0)]
    assert close == (Command.CLOSE, 1)


def test_over_the_wires_it_drives_a_metre_and_leaves_both_devices_at_rest(tmp_path) -> None:
    outputs = []
    with Lab() as lab:
        with Running(open_base(FAST, lab.robot_port, lab.laser_port, outputs.append, tmp_path)) as running:
            wait_for(lambda: arrived(running.base, outputs))
            was_lost = any(output.mission.state is MissionState.STOPPED for output in outputs)  # by a busy machine
            assert was_lost or abs(lab.pose.x_m - 1.0) < 0.06  # how far it rolled then nobody knows
            assert abs(lab.pose.y_m) < 0.06
        assert running.error is None
        assert running.base.lateness.cycles > 40
        wait_for(lambda: not lab.robot.open)
        assert_ended_by_a_stop(lab)
        assert not lab.scanner.streaming


def test_a_process_that_is_told_to_end_while_it_drives_stops_the_robot_last(tmp_path) -> None:
    with Lab() as lab:
        child = subprocess.Popen([sys.executable, "-c", CHILD, lab.robot_port, lab.laser_port, str(tmp_path)])
        try:
            wait_for(lab.drives)
            child.send_signal(signal.SIGTERM)
            assert child.wait(30) == 0
        finally:
            child.kill()
            child.wait()
        wait_for(lambda: not lab.robot.open)
        assert_ended_by_a_stop(lab)


class Driver:
    """Of a robot or a laser, that gives nothing; raises: by name of the call; told: in order, by whom."""

    def __init__(self, name: str, told: list[str], **raises: Exception) -> None:
        self.health, self._name, self._told, self._raises = Health(name, HealthState.OK), name, told, raises

    def _tell(self, call: str) -> list:
        if call in self._raises:
            raise self._raises[call]
        self._told.append(f"{self._name} {call}")
        return []

    def __getattr__(self, call: str):
        return lambda *_: self._tell(call)


def base_of(told: list[str], robot=None, laser=None, watcher=lambda outputs: None) -> Base:
    devices = Driver("robot", told, **(robot or {})), Driver("laser", told, **(laser or {}))
    return Base(BaseLoop(CONFIG), *devices, (Ending(), Ending()), 1_000_000, watcher)


def test_an_error_in_the_loop_closes_both_devices_and_is_raised() -> None:
    told: list[str] = []

    def watcher(outputs) -> None:
        if "robot poll" in told and "laser read" in told:
            raise ZeroDivisionError("oops")

    with pytest.raises(ZeroDivisionError, match="oops"):
        base_of(told, watcher=watcher).run()
    assert [each for each in told if each.startswith("robot")][-1] == "robot close"
    assert [each for each in told if each.startswith("laser")][-1] == "laser close"


@pytest.mark.parametrize("device", ["robot", "laser"])
@pytest.mark.parametrize("call", ["start", "poll"])
def test_an_error_at_any_call_of_a_device_closes_it_and_is_what_the_robot_stands_for(device: str, call: str) -> None:
    told: list[str] = []
    outputs = []
    raises = {"read" if (device, call) == ("laser", "poll") else call: ZeroDivisionError("oops")}
    with Running(base_of(told, **{device: raises}, watcher=outputs.append)) as running:
        wait_for(lambda: outputs and "closed after ZeroDivisionError: oops" in outputs[-1].decision.reason)
        assert f"{device}: closed after ZeroDivisionError" in answer(lambda: running.base.goto([AHEAD]))
        wait_for(lambda: f"{device} close" in told)  # right after it is known
    assert running.error is None
    assert {output.command.v_mps for output in outputs} == {0.0}


def test_a_port_that_another_instance_holds_ends_the_base_with_who_it_is() -> None:
    told: list[str] = []
    with pytest.raises(PortBusyError, match="held by another"):
        base_of(told, robot={"start": PortBusyError("ttyX: expected a free port, it is held by another")}).run()
    assert told[-1] in ("robot close", "laser close")


def test_orders_of_other_threads_are_carried_out_between_two_steps() -> None:
    outputs = []
    with Running(base_of([], watcher=outputs.append)) as running:
        assert "resume: expected a mission that is stopped" in answer(running.base.resume)
        assert answer(lambda: running.base.stop("operator")) == ""
        wait_for(lambda: outputs and "operator" in outputs[-1].decision.reason)
        assert answer(running.base.cancel) == ""
        assert answer(running.base.resume) == ""
        wait_for(lambda: "operator" not in outputs[-1].decision.reason)
