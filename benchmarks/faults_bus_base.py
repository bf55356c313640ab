# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the bus against `edgefusion base` and its simulated robot on ptys: until the robot is told to stand.

Z1 and Z2 where an operator is required, Z3 and Z4 where one drives, Z7 where one floods.
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from typing import Callable, Iterator, List, Mapping, Tuple

import numpy as np
from benchmarks.fault_row import FaultRow
from benchmarks.faults_base_rig import BaseRig, hall
from benchmarks.faults_bus_commands import commands_that_are_none
from benchmarks.faults_bus_rig import resident_bytes

from edgefusion.bus.client import Robot
from edgefusion.errors import RefusedError
from edgefusion.types import Twist2D

FLOOD_S, FLOOD_HZ = 10.0, 10_000
MB = 1e6

Tick = Callable[[], object]


def on_a_base(seeds: int, tick: Tick) -> List[FaultRow]:
    """tick: called after every run."""
    halted, killed, ended = [], [], []
    for seed in range(seeds):
        halted.append(_operator_halted(seed))
        killed.append(_router_killed(seed))
        ended.append(_driver_ends(seed))
        tick()
    stand = "the robot is told to stand"
    return [
        FaultRow("Z1", f"operator required, router killed: {stand}", "1 s", 1.0, killed),
        FaultRow("Z2", f"operator required, and halted (SIGSTOP): {stand}", "500 ms + a cycle", 0.55, halted),
        FaultRow("Z3", f"an operator's velocities end: {stand}", "300 ms", 0.3, ended),
        *commands_that_are_none(seeds, tick),
        _flooded(tick),
    ]


def _operator_halted(seed: int) -> float:
    with _attended(seed) as (rig, operator):
        operator.send_signal(signal.SIGSTOP)
        since_ns = time.monotonic_ns()
        try:
            return rig.stopped_after_s(since_ns)
        finally:
            operator.send_signal(signal.SIGCONT)


def _router_killed(seed: int) -> float:
    with _attended(seed) as (rig, _):
        rig.processes["bus"].kill()
        return rig.stopped_after_s(time.monotonic_ns())


@contextmanager
def _attended(seed: int) -> Iterator[Tuple[BaseRig, subprocess.Popen[str]]]:
    """A robot that requires an operator and drives at speed, and its operator."""
    with hall(seed) as rig:
        file = rig.folder / "robot.toml"
        text = file.read_text(encoding="utf-8").replace("[service]", "require_operator = true\n[service]")
        file.write_text(text, encoding="utf-8")
        for verb in ("bus", "base"):
            rig.start(verb)
        client = rig.connect()
        operator = _play(rig, "operator")
        try:
            rig.wait(lambda: _resumed(client))
            rig.drive(client)
            time.sleep(float(np.random.default_rng(seed).uniform(0.0, 0.3)))
            yield rig, operator
        finally:
            operator.kill()
            operator.wait()


def _resumed(client: Robot) -> bool:
    with suppress(RefusedError, ConnectionError):
        client.resume()
        return True
    return False


def _driver_ends(seed: int) -> float:
    """From the last velocity on, after it was driven for a second."""
    with hall(seed) as rig:
        for verb in ("bus", "base"):
            rig.start(verb)
        client, end_s = rig.connect(), math.inf
        said_ns = 0
        while time.monotonic() < end_s:
            with suppress(ConnectionError):  # base is not there yet
                client.drive(Twist2D(0.3))
                said_ns = time.monotonic_ns()
            if rig.speed_mps > 0.2 and end_s == math.inf:
                end_s = time.monotonic() + 0.5 + float(np.random.default_rng(seed).uniform(0.0, 0.1))
            time.sleep(0.05)
        return rig.stopped_after_s(said_ns)


def _flooded(tick: Tick) -> FaultRow:
    with hall(0) as rig:
        for verb in ("bus", "base"):
            rig.start(verb)
        client = rig.connect()
        rig.wait(lambda: "cycles" in _figures(client))
        pid = rig.processes["base"].pid
        _play(rig, "driver", "20", "60").wait()  # what it needs to be driven at all
        before = resident_bytes(pid)
        flood = _play(rig, "driver", str(FLOOD_HZ), str(round(FLOOD_HZ * FLOOD_S)))
        since_s = time.monotonic()
        flood.wait(10 * FLOOD_S)
        hz = FLOOD_HZ * FLOOD_S / (time.monotonic() - since_s)
        time.sleep(1.0)  # until it says so
        figures, grown_mb = _figures(client), (resident_bytes(pid) - before) / MB
    tick()
    refused = figures.get("cmd_vel refused, too many", "0")
    remark = f"{hz:.0f} a second were sent, of those {refused} refused; its memory grew by {grown_mb:.1f} MB"
    p99_s = float(figures["lateness p99 [ms]"]) / 1e3
    what = "an operator's flood of velocities: base is late, p99"
    return FaultRow("Z7", what, "20 ms", 0.02, [p99_s], remark, grown_mb > 3 * 5 or refused == "0")


def _figures(client: Robot) -> Mapping[str, str]:
    return next((each.figures for each in client.status.healths if each.health.component == "base"), {})


def _play(rig: BaseRig, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "benchmarks.bus_players", arguments[0], rig.endpoint, "", *arguments[1:]]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    return process
