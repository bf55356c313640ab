# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""R1, R2, R6 and R9 in real time: a robot's line that breaks, falls silent, is not read, or is wanted twice."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import List, Set

from benchmarks.fault_row import FaultRow
from benchmarks.faults_robot_rig import Rig, Rng, driven, stays

from edgefusion.service.cadence import Cadence
from edgefusion.sim.fault_frames import SIP
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import Fault

_REPORT_BYTES = 55
_LOOP_NS, _LOOP_CYCLES, _FILLINGS = 50_000_000, 40, 10
_STAYS_S, _SHARE, _CYCLE_NS = 1.0, 0.2, 100_000_000


def unplugged(rngs: List[Rng]) -> List[FaultRow]:
    """R1."""
    lost: List[float] = []
    back: List[float] = []
    shares: List[float] = []
    moved = 0
    for rng in rngs:
        with driven(rng) as rig:
            injected_ns = time.monotonic_ns()
            rig.unplug()
            lost.append(rig.lost_after_s(injected_ns))
            rig.drives = False
            shares.append(_share_of_a_core(0.3 + rng.random()))
            plugged_ns = time.monotonic_ns()
            rig.plug()
            back.append(rig.stopped_after_s(plugged_ns))
            rig.wait(lambda: not rig.is_lost)
            time.sleep(_STAYS_S)
            moved += rig.moved_since(plugged_ns)
    remark = f"at most {100 * max(shares):.0f} % of a core while it is gone, the simulator's included"
    return [
        FaultRow("R1", "unplugged, until lost", "100 ms", 0.1, lost, remark, max(shares) > _SHARE),
        FaultRow("R1", "plugged in again, until told to stop", "1 s", 1.0, back, stays(moved), moved > 0),
    ]


def _share_of_a_core(seconds: float) -> float:
    used_s, begun_s = time.process_time(), time.monotonic()
    time.sleep(seconds)
    return (time.process_time() - used_s) / (time.monotonic() - begun_s)


def silent(rngs: List[Rng]) -> List[FaultRow]:
    """R2."""
    return [FaultRow("R2", "silent after any byte, until lost", "300 ms", 0.3, [_silent_after_s(rng) for rng in rngs])]


def _silent_after_s(rng: Rng) -> float:
    """From its last byte on."""
    with driven(rng) as rig:
        offset = float(rng.integers(0, _REPORT_BYTES + 1))
        rig.device = FaultyWire(rig.robot, SIP, Fault("robot", "off", offset), rng, time.monotonic_ns())
        injected_ns = time.monotonic_ns()
        rig.wait(lambda: rig.is_lost and rig.failed_ns > injected_ns)
        return (rig.failed_ns - rig.said_ns) / 1e9


def not_read(rngs: List[Rng]) -> List[FaultRow]:
    """R6."""
    seconds: List[float] = []
    late: List[float] = []
    for rng in rngs:
        with driven(rng) as rig:
            rig.reads = False
            _fill(rig.port)
            injected_ns = time.monotonic_ns()
            loop = Cadence(_LOOP_NS, time.monotonic_ns, time.sleep)
            for _ in range(_LOOP_CYCLES):
                loop.next()
            seconds.append(rig.lost_after_s(injected_ns))
            late.append(loop.lateness.p99_ms / 1e3)
            rig.reads = True
    return [
        FaultRow("R6", "nobody reads, until lost", "100 ms after the next write", 0.15, seconds),
        FaultRow("R6", "a loop of 20 Hz meanwhile, 99 of 100 cycles late by", "20 ms", 0.02, late),
    ]


def _fill(port: str) -> None:
    """All that a pty takes while nobody reads; it makes room for more some time after it was full."""
    descriptor = os.open(port, os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
    for _ in range(_FILLINGS):
        with suppress(BlockingIOError):
            while True:
                os.write(descriptor, bytes(1))
        time.sleep(0.002)
    os.close(descriptor)


def second_instance(rngs: List[Rng]) -> List[FaultRow]:
    """R9."""
    seconds: List[float] = []
    wrong = lost = 0
    for rng in rngs:
        with driven(rng) as rig:
            stamps: Set[int] = set()
            begun_s = time.monotonic()
            command = [sys.executable, "-m", "edgefusion.cli", "robot", rig.port, "--once"]
            environment = {**os.environ, "TMPDIR": str(Path(rig.port).parent)}
            second = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment)
            while second.poll() is None:
                _note(rig, stamps)
            seconds.append(time.monotonic() - begun_s)
            error = second.communicate()[1]
            wrong += second.returncode != 2 or f"the first (pid {os.getpid()})" not in error
            end_s = time.monotonic() + 0.3
            while time.monotonic() < end_s:
                _note(rig, stamps)
            lost += round((max(stamps) - min(stamps)) / _CYCLE_NS) + 1 - len(stamps)
    remark = f"{wrong} not refused by name; the first lost {lost} packets"
    return [FaultRow("R9", "a second instance, until it has ended", "1 s", 1.0, seconds, remark, wrong + lost > 0)]


def _note(rig: Rig, stamps: Set[int]) -> None:
    report = rig.thread.news.newest
    if report is not None:
        stamps.add(report.state.stamp_ns)
    time.sleep(0.005)
