# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""S2 to S4 against `edgefusion base` in real time: wall clocks that step, a halt, and processors that others have.

S1 is about stamps alone (`faults_skew.py`).
"""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Iterator, List, Tuple

import numpy as np
from benchmarks import faults_skew
from benchmarks.fault_row import FaultRow
from benchmarks.faults_base_rig import BaseRig, driving
from benchmarks.scheduling import CORES, unprivileged
from benchmarks.wall_clock import WallClock

from edgefusion.bus.client import Robot
from edgefusion.types import Twist2D

HOUR_S, YEARS_S = 3600.0, 3652 * 86400.0
STEPS_S = (HOUR_S, -HOUR_S, YEARS_S, -YEARS_S, -1.0)
HALT_S, LATE_S = 1.0, (0.22, 0.4)
_STEP_S, _LOADED_S, _GAP_S, _BARE_CYCLES = 0.7, 5.0, 0.2, 100
_NO_TIME = float("inf")

Tick = Callable[[], object]
Rng = np.random.Generator


def rows(seeds: int, tick: Tick = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each run."""
    return [*faults_skew.rows(seeds, tick), *stepping(seeds, tick), *halted(seeds, tick), *starved(seeds, tick)]


def stepping(seeds: int, tick: Tick) -> List[FaultRow]:
    """S2."""
    what = "wall clock of bus and base steps by 1 h, 10 years and 1 s"
    stops, steps, silent = 0, 0, 0.0
    off: List[float] = []
    deaf: List[float] = []
    try:
        for seed in range(seeds):
            with tempfile.TemporaryDirectory() as folder:
                clock = WallClock(Path(folder))
                with driving(seed, clock.environment) as (rig, client):
                    found = _stepped(rig, client, clock)
                    stops, steps, silent = stops + found[0], steps + len(STEPS_S), max(silent, found[1])
                    deaf.append(_no_more_commands(rig, client, clock))
                with driving(seed, clock.environment) as (rig, _):
                    off.append(_no_more_scans(rig, clock, STEPS_S[seed % len(STEPS_S)]))
            tick()
    except RuntimeError as error:
        if "compiler" not in str(error):
            raise
        return [FaultRow("S2", what, "no stop", _NO_TIME, remark=f"not tried: {error}")]
    remark = f"{stops} stops in {steps} steps; its state heard every {1e3 * silent:.0f} ms at worst"
    return [
        FaultRow("S2", what, "no stop, and it is heard on", _NO_TIME, [], remark, stops > 0 or silent > 1.0),
        FaultRow("S2", "the same, as the laser falls silent, until told to stop", "200 ms", 0.2, off),
        FaultRow("S2", "the same, as an operator's commands end, until told to stop", "300 ms", 0.3, deaf),
    ]


def _stepped(rig: BaseRig, client: Robot, clock: WallClock) -> Tuple[int, float]:
    """How often it was told to stand while the clock stepped, and the longest time without its mission's state [s]."""
    begin_ns, longest_s = time.monotonic_ns(), 0.0
    for ahead_s in STEPS_S:
        clock.set(ahead_s)
        end_s = time.monotonic() + _STEP_S
        while time.monotonic() < end_s:
            longest_s = max(longest_s, client.status.age_s or 0.0)
            time.sleep(0.005)
    return sum(stands for _, stands in rig.motions(begin_ns)), longest_s


def _no_more_scans(rig: BaseRig, clock: WallClock, ahead_s: float) -> float:
    clock.set(ahead_s)
    rig.switch_off("laser")
    return rig.stopped_after_s(time.monotonic_ns())


def _no_more_commands(rig: BaseRig, client: Robot, clock: WallClock) -> float:
    """After it was driven by them for a second."""
    begin_ns = said_ns = time.monotonic_ns()
    while said_ns - begin_ns < 1e9:
        time.sleep(0.05)
        client.drive(Twist2D(0.3))
        said_ns = time.monotonic_ns()
    clock.set(-HOUR_S)
    return rig.stopped_after_s(said_ns)


def halted(seeds: int, tick: Tick) -> List[FaultRow]:
    """S3."""
    first: List[float] = []
    again: List[float] = []
    moved = 0
    for seed in range(seeds):
        with driving(seed) as (rig, _):
            time.sleep(float(np.random.default_rng(seed).uniform(0.0, 0.3)))
            on_ns = _halt(rig, HALT_S)
            told_ns, stands = rig.first_motion(on_ns)
            moved += not stands
            first.append((told_ns - on_ns) / 1e9)
            rig.wait(lambda: any(not stands for _, stands in rig.motions(on_ns)))  # noqa: B023
            again.append((next(ns for ns, stands in rig.motions(on_ns) if not stands) - on_ns) / 1e9)
        tick()
    remark = f"{moved} said another first; a new command after {1e3 * min(again):.0f} ms at least, by five new scans"
    aim = "the first is to stop, 100 ms"
    return [FaultRow("S3", "base halted for 1 s, until it says something", aim, 0.1, first, remark, moved > 0)]


def _halt(rig: BaseRig, seconds: float) -> int:
    """Of base alone; when it goes on."""
    base = rig.processes["base"]
    base.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    on_ns = time.monotonic_ns()
    base.send_signal(signal.SIGCONT)
    return on_ns


def starved(seeds: int, tick: Tick) -> List[FaultRow]:
    """S4."""
    return [*_starved("as any other process", unprivileged, seeds, tick), *_starved("in real time", None, seeds, tick)]


def _starved(word: str, prepare: Callable[[], None] | None, seeds: int, tick: Tick) -> List[FaultRow]:
    """prepare: called in its process. The bare loop beside it tells what the machine gives anybody."""
    late: List[float] = []
    stopped: List[float] = []
    unsaid, worst_ms, bare_s = 0, 0.0, 0.0
    for seed in range(seeds):
        with _hogs(), driving(seed, prepare=prepare) as (rig, client):
            bare_s = max(bare_s, _bare_s() if prepare else 0.0)
            time.sleep(_LOADED_S)
            figures = next(each.figures for each in client.status.healths if each.health.component == "base")
            late.append(float(figures["lateness p99 [ms]"]) / 1e3)
            worst_ms = max(worst_ms, float(figures["lateness max [ms]"]))
            unsaid += _drove_on(rig)
            stopped.append(rig.stopped_after_s(_halt(rig, float(np.random.default_rng(seed).uniform(*LATE_S)))))
        tick()
    what = f"{2 * CORES} busy processes on {CORES} cores, base {word}: 99 of 100 cycles late by"
    beside = f"; a bare loop beside it that works for 8 ms of each cycle: {1e3 * bare_s:.0f} ms" if bare_s else ""
    remark = f"the worst {worst_ms:.0f} ms; {unsaid} pauses over 0.2 s without a stop after{beside}"
    return [
        FaultRow("S4", what, "50 ms", 0.05, late, remark, unsaid > 0),
        FaultRow("S4", "the same, kept from a cycle for over 0.2 s, until told to stop", "100 ms", 0.1, stopped),
    ]


def _drove_on(rig: BaseRig) -> int:
    """How often it was told to go on after it had been told nothing for too long."""
    motions, longest_ns = rig.motions(), (_GAP_S + 0.1) * 1e9
    pairs = zip(motions, motions[1:])
    return sum(not (was or stands) and ns - then_ns > longest_ns for (then_ns, was), (ns, stands) in pairs)


def _bare_s() -> float:
    """By how much a loop that is nothing else is late meanwhile, as any other process."""
    command = [sys.executable, "-m", "benchmarks.bare_loop", str(_BARE_CYCLES)]
    return float(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout) / 1e3


@contextmanager
def _hogs() -> Iterator[None]:
    argv: List[Any] = [sys.executable, "-c", "while True: pass"]
    hogs = [subprocess.Popen(argv) for _ in range(2 * CORES)]
    try:
        yield
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()
