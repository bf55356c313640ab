# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated Pioneer in a room, and `edgefusion bus` and `edgefusion base` as processes, for a client beside them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Callable

from base_lab import Lab, wait_for
from bus_lab import free_port
from edgefusion.bus.client import Errand, Robot, connect
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.messages.mission_report import MissionReport

CONFIG = """
[robot]
port = "{robot}"
[laser]
port = "{laser}"
baudrate = 500000
[mission]
interest = []
[bus]
listen = ["{endpoint}"]
{bus}
[service]
processes = ["bus", "base"]
"""
STOPS = {(Command.STOP, 0), (Command.E_STOP, 0), (Command.VEL, 0), (Command.CLOSE, 1)}

LATE_NS = 150_000_000
"""A robot that is told nothing for so long, instead of every 50 ms, is in a simulator, or has a base, that is late."""

DRIVES = 9
"""So often a goal is asked for again that a machine which is too busy had given up."""


def agrees(ask: Callable[[], object]) -> bool:
    """Whether the robot does now what it is asked for."""
    try:
        ask()
    except (RefusedError, ConnectionError):
        return False
    return True


def given_up(report: MissionReport) -> bool:
    """Whether it stands with nothing to go on with: also a simulator that is late for 0.25 s comes to that."""
    return report.state in ("idle", "stopped") and not report.goal_id


class BusRobot:
    """bus: further lines of the section. processes: by verb, those that were started and not ended."""

    def __init__(self, folder: Path, bus: str = "") -> None:
        self._stack, self.lab = ExitStack(), Lab()
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self._file = folder / "robot.toml"
        self._environment = {**os.environ, "TMPDIR": str(folder)}  # where ports are locked
        self._file.write_text(
            CONFIG.format(robot=self.lab.robot_port, laser=self.lab.laser_port, endpoint=self.endpoint, bus=bus)
        )
        self.processes: dict[str, subprocess.Popen] = {}

    def __enter__(self) -> BusRobot:
        self._stack.enter_context(self.lab)
        self._stack.callback(self._kill)
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def start(self, *verbs: str) -> BusRobot:
        for verb in verbs:
            argv = [sys.executable, "-m", "edgefusion.cli", verb, "--config", str(self._file)]
            self.processes[verb] = subprocess.Popen(argv, env=self._environment)
        return self

    def end(self, verb: str, number: int = signal.SIGTERM) -> int:
        """The exit code."""
        process = self.processes[verb]
        process.send_signal(number)
        code = process.wait(30)
        del self.processes[verb]
        return code

    def child_of(self, parent: str, verb: str) -> int:
        """Its process id."""
        pid = self.processes[parent].pid
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            if f"\0{verb}\0".encode() in Path(f"/proc/{child}/cmdline").read_bytes():
                return int(child)
        raise AssertionError(f"no {verb} runs")

    def connect(self) -> Robot:
        robots: list[Robot] = []

        def connected() -> bool:
            try:
                robots.append(connect(self.endpoint))
            except ConnectionError:
                return False
            return True

        wait_for(connected)
        return self._stack.enter_context(robots[0])

    def go(self, robot: Robot, x_m: float = 3.0, leave_stop: bool = True) -> Errand:
        """Once it may. leave_stop: where it may not, as one that a machine which is too busy had lost: its motors are
        off until then."""
        errands: list[Errand] = []

        def accepted() -> bool:
            if agrees(lambda: errands.append(robot.goto(x_m, 0.0))):
                return True
            if leave_stop:
                agrees(robot.resume)
            return False

        wait_for(accepted)
        return errands[0]

    def drive(self, robot: Robot, x_m: float = 3.0, speed_mps: float = 0.2) -> Errand:
        """Until it is on its way, at speed."""
        return self.at_speed(robot, self.go(robot, x_m), x_m, speed_mps)

    def at_speed(self, robot: Robot, errand: Errand, x_m: float = 3.0, speed_mps: float = 0.2) -> Errand:
        """Until it is; the errand is another where a machine that is too busy had this one given up."""
        errands = [errand]

        def drives() -> bool:
            mission = robot.status.mission
            if mission is not None and mission.stamp_ns >= errands[-1].since_ns and given_up(mission):
                errands.append(self.go(robot, x_m))
            return self.moving(speed_mps)

        wait_for(drives)
        return errands[-1]

    def arrive(self, robot: Robot, errand: Errand, x_m: float) -> list[str]:
        """The states of the mission until it ends. A goal that was given up is asked for again, but only where the
        machine was too busy: else that is what fails."""
        for _ in range(DRIVES):
            states: list[str] = []
            for report in robot.progress(errand, 30.0):
                if given_up(report):
                    break
                states.append(report.state)
            else:
                return states
            assert self.was_late(errand.since_ns), f"given up: {report.reason}"
            errand = self.go(robot, x_m)
        raise AssertionError("this machine is too busy")

    def was_late(self, since_ns: int) -> bool:
        """Whether the robot was told nothing for so long that it has to do with this machine."""
        heard_ns = [since_ns, *(ns for ns, *_ in self.lab.motions() if ns > since_ns), time.monotonic_ns()]
        return any(after - before > LATE_NS for before, after in zip(heard_ns, heard_ns[1:]))

    def moving(self, speed_mps: float = 0.2) -> bool:
        return self.lab.world.body.twist.v_mps > speed_mps

    def stopped_after_s(self, since_ns: int) -> float:
        """From then until the robot was told to stand [s]."""

        def first() -> list[int]:
            return [ns for ns, number, value in self.lab.motions() if ns >= since_ns and (number, value) in STOPS]

        wait_for(first)
        return (first()[0] - since_ns) / 1e9

    def velocities(self, since_ns: int) -> set[int]:
        """What the robot was told since then [mm/s]."""
        return {value for ns, number, value in self.lab.motions() if ns >= since_ns and number == Command.VEL}

    def last_motion(self) -> tuple[int, int]:
        return self.lab.motions()[-1][1:]

    def _kill(self) -> None:
        for process in self.processes.values():
            process.kill()
            process.wait()
