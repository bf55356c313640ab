# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of processes that die or hang, in real time: R5, I5 and Y4, and how long the end takes."""

from __future__ import annotations

import signal
import time
from typing import Callable, List

import numpy as np
from benchmarks.fault_row import FaultRow
from benchmarks.faults_supervisor_rig import WATCHDOG_S, Rng, SupervisorRig, supervised

from edgefusion.drivers.sip_command import Command

_CRASHES, _RESTART_S, _MISSED_S = 5, 0.5, 0.3
_DEATHS = (signal.SIGSEGV, signal.SIGKILL)


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each."""
    rngs = [np.random.default_rng(seed) for seed in range(seeds)]
    found: List[FaultRow] = []
    for figure in (dead_base, dead_vision, hung_supervisor, end):
        found += figure(rngs)
        tick()
    return found


def dead_base(rngs: List[Rng]) -> List[FaultRow]:
    """R5."""
    killed: List[float] = []
    halted: List[float] = []
    for rng in rngs:
        for times, number in ((killed, signal.SIGKILL), (halted, signal.SIGSTOP)):
            with supervised(rng) as rig:
                times.append(rig.stopped_after_s(rig.kill("base", number)))
    remark = "taken for dead after 1.5 s"
    return [
        FaultRow("R5", "base killed at speed, until told to stop", "500 ms", 0.5, killed),
        FaultRow("R5", "base halted at speed, until told to stop", "2 s", 2.0, halted, remark),
    ]


def dead_vision(rngs: List[Rng]) -> List[FaultRow]:
    """I5; by turns it is killed and crashes."""
    back: List[float] = []
    gaps: List[float] = []
    given_up = 0
    for rng in rngs:
        with supervised(rng) as rig:
            begun_ns = time.monotonic_ns()
            back += [_crash(rig, _DEATHS[number % 2]) for number in range(_CRASHES - 1)]
            rig.kill("vision", _DEATHS[_CRASHES % 2])
            rig.wait(lambda: "given up after 5 failures" in rig.status)
            given_up += 1
            gaps.append(rig.longest_gap_s(begun_ns))
    remark = f"given up after the fifth in {given_up} of {len(rngs)}; the robot heard something every {max(gaps):.2f} s"
    bad = max(gaps) > _MISSED_S or given_up < len(rngs)
    return [FaultRow("I5", "vision crashes, until it lives again", "5 s", 5.0, back, remark, bad)]


def _crash(rig: SupervisorRig, number: int) -> float:
    said, killed_ns = rig.status, rig.kill("vision", number)
    rig.wait(lambda: rig.status != said and "vision ok" in rig.status)
    return (time.monotonic_ns() - killed_ns) / 1e9


def hung_supervisor(rngs: List[Rng]) -> List[FaultRow]:
    """Y4, with systemd's part played: what it does after WatchdogSec=2 without a word, and RestartSec later."""
    times: List[float] = []
    for rng in rngs:
        with supervised(rng) as rig:
            times.append(_halted_s(rig))
    return [FaultRow("Y4", "supervisor halted, until ready again", "5 s", 5.0, times, "2.5 s of them are systemd's")]


def _halted_s(rig: SupervisorRig) -> float:
    """Until the next one is ready; base of the old one has told the robot to stop before."""
    rig.process.send_signal(signal.SIGSTOP)
    halted_ns = time.monotonic_ns()
    time.sleep(WATCHDOG_S)
    for number in (signal.SIGABRT, signal.SIGCONT):
        rig.process.send_signal(number)
    rig.process.wait()
    rig.wait(lambda: rig.robot.heard[-1][1].number == Command.CLOSE)
    time.sleep(_RESTART_S)
    rig.start()
    rig.wait(lambda: rig.heard_ns("READY=1", halted_ns))
    return (time.monotonic_ns() - halted_ns) / 1e9


def end(rngs: List[Rng]) -> List[FaultRow]:
    """The end as it should be, and with children that do not listen."""
    well: List[float] = []
    deaf: List[float] = []
    for rng in rngs:
        for times, halts in ((well, False), (deaf, True)):
            with supervised(rng) as rig:
                if halts:
                    rig.kill("base", signal.SIGSTOP)
                begun_ns = time.monotonic_ns()
                times.append(rig.end())
                rig.stopped_after_s(begun_ns)
    what, remark = "SIGTERM, until it has ended", "and the robot was told to stop"
    return [
        FaultRow("end", what, "3 s", 3.0, well, remark),
        FaultRow("end", f"{what}, with a halted base", "3 s", 3.0, deaf, remark),
    ]
