# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot that drives and turns while its vision has more to do than the processors can: how late its base is then."""

from __future__ import annotations

import os
import shutil
import threading
import time
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from benchmarks.end_to_end_robot import RobotProcess, RobotSetup, free_endpoint, write_config
from benchmarks.end_to_end_world import LiveRun
from benchmarks.joining import joined
from benchmarks.process_memory import busy_s, processes, spent_by_all

from edgefusion.bus.client import Robot
from edgefusion.bus.session import UnreachableError
from edgefusion.errors import RefusedError
from edgefusion.sim.live_devices import LiveSetup
from edgefusion.sim.world_file import load_world
from edgefusion.types import HealthState

GOALS = ((0.0, 0.0, 0.0), (0.0, 0.0, 1.7), (0.7, 0.7, 0.8), (0.7, 0.7, 0.0), (0.7, 0.7, 1.7))
"""Turned to where most of the laboratory's objects stand, for all but a few seconds."""

READY_S = 90.0
WINDOW_S = 62.0
"""The figures of lateness are those of the last 1200 cycles: a minute at 20 Hz."""


@dataclass(frozen=True)
class Load:
    """How late cycles were [ms] while vision had work. worst: since the base was started. real_time: how many of its
    threads have it. cores: what each process had of the processors. busy: which share of all processors somebody had.
    figures: what the detector said of itself."""

    cycles: int
    p50: float
    p99: float
    worst: float
    real_time: int
    cores: Mapping[str, float]
    busy: float
    figures: Mapping[str, str]


def unprivileged() -> Sequence[str]:
    """What a command is begun with so that it may not ask for real time. Raises RefusedError where that needs a
    program that is missing."""
    if os.geteuid() != 0:
        return ()
    if shutil.which("setpriv") is None:
        raise RefusedError("as root expected setpriv, of util-linux, to begin a process that may less")
    return ("setpriv", "--bounding-set", "-sys_nice")


def loaded(setup: RobotSetup, folder: Path, wrapper: Sequence[str], window_s: float = WINDOW_S) -> Load:
    """Raises UnreachableError where the robot is not well in time."""
    folder.mkdir(parents=True, exist_ok=True)
    endpoint = free_endpoint()
    with ExitStack() as stack:
        live = LiveRun(LiveSetup(load_world("laboratory"), robot_port=0))
        stack.callback(live.close)
        _pumped(live, stack)
        process = RobotProcess(write_config(folder, live.devices, setup, endpoint), folder / "robot.log", wrapper)
        stack.callback(process.end)
        robot = stack.enter_context(joined(endpoint, READY_S))
        _wait_until_well(robot)
        before, all_before = _busy(process.pid), spent_by_all()
        begun_s = time.monotonic()
        _drive_about(robot, begun_s + window_s)
        reports, spent_s = _figures(robot), time.monotonic() - begun_s
        after, busy = _busy(process.pid), spent_by_all().busy_since(all_before)
        lived = before.keys() & after.keys()  # who was started anew meanwhile has another number
        cores = {name: (after[name, pid] - before[name, pid]) / spent_s for name, pid in lived}
        base = reports["base"]
        late = [float(base[f"lateness {name} [ms]"]) for name in ("p50", "p99", "max")]
        threads = _in_real_time(processes(process.pid)["base"])
        return Load(int(base["cycles"]), late[0], late[1], late[2], threads, cores, busy, reports["detector"])


def _pumped(live: LiveRun, stack: ExitStack) -> None:
    """The world goes on in a thread."""
    over: List[bool] = []
    thread = threading.Thread(target=lambda: live.until(lambda: over, 1e6), daemon=True)
    thread.start()

    def end() -> None:
        over.append(True)
        thread.join()

    stack.callback(end)


def _drive_about(robot: Robot, until_s: float) -> None:
    turn = 0
    while time.monotonic() < until_s:
        if robot.status.mission is None or robot.status.mission.state != "driving":
            with suppress(RefusedError, UnreachableError):
                robot.goto(*GOALS[turn % len(GOALS)])
                turn += 1
        time.sleep(0.5)


def _wait_until_well(robot: Robot) -> None:
    """Vision as well: it is what makes the others late."""
    end_s, ills = time.monotonic() + READY_S, ["nothing was heard"]
    while ills:
        if time.monotonic() > end_s:
            raise UnreachableError(f"expected a robot that is well within {READY_S:g} s, got {', '.join(ills)}")
        time.sleep(0.05)
        healths = [report.health for report in robot.status.healths]
        ills = [f"{each.component}: {each.reason}" for each in healths if each.state is not HealthState.OK]
        ills += [] if any(each.component == "detector" for each in healths) else ["detector: not heard yet"]


def _figures(robot: Robot) -> Dict[str, Mapping[str, Any]]:
    return {report.health.component: report.figures for report in robot.status.healths}


def _busy(supervisor: int) -> Dict[Tuple[str, int], float]:
    return {(name, pid): busy_s(pid) for name, pid in processes(supervisor).items()}


def _in_real_time(pid: int) -> int:
    tasks: Tuple[int, ...] = tuple(int(task.name) for task in Path(f"/proc/{pid}/task").iterdir())
    mask = ~os.SCHED_RESET_ON_FORK
    return sum(os.sched_getscheduler(task) & mask == os.SCHED_FIFO for task in tasks)
