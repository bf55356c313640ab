# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of the robot's faults in real time: R1 to R4 and R6 to R9, through ptys, threads and processes."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Callable, Iterator, List, Set

import numpy as np
from benchmarks.fault_row import FaultRow
from benchmarks.faults_robot_noise import noisy_drive
from benchmarks.faults_robot_rig import UNTOUCHED, Rig

from edgefusion.service.cadence import Cadence
from edgefusion.sim.fault_frames import SIP
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import Fault
from edgefusion.types import Pose2D

Rng = np.random.Generator

NOISY_PACKETS = 50_000
"""Each seed's; of twenty seeds a million."""

_REPORT_BYTES = 55
_LOOP_NS, _LOOP_CYCLES, _FILLINGS = 50_000_000, 40, 10
_STAYS_S, _SHARE, _CONTINUOUS_M, _CYCLE_NS = 1.0, 0.2, 0.04, 100_000_000


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each."""
    rngs = [np.random.default_rng(seed) for seed in range(seeds)]
    found: List[FaultRow] = []
    for figure in (_unplugged, _silence, _noise, _started_anew, _not_read, _jams, _unwell, _second_instance):
        found += figure(rngs)
        tick()
    return found


def _silence(rngs: List[Rng]) -> List[FaultRow]:
    return [FaultRow("R2", "silent after any byte, until lost", "300 ms", 0.3, [_silent(rng) for rng in rngs])]


def _jams(rngs: List[Rng]) -> List[FaultRow]:
    seconds = [_jammed(rng) for rng in rngs]
    return [FaultRow("R7", "wheels that do not turn, until told to stop", "1.1 s", 1.1, seconds)]


@contextmanager
def _driven(rng: Rng) -> Iterator[Rig]:
    """At its speed, for a random while."""
    with tempfile.TemporaryDirectory() as folder, Rig(Path(folder)) as rig:
        time.sleep(0.2 * rng.random())
        yield rig


def _unplugged(rngs: List[Rng]) -> List[FaultRow]:
    lost: List[float] = []
    back: List[float] = []
    shares: List[float] = []
    moved = 0
    for rng in rngs:
        with _driven(rng) as rig:
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
        FaultRow("R1", "plugged in again, until told to stop", "1 s", 1.0, back, _stays(moved), moved > 0),
    ]


def _share_of_a_core(seconds: float) -> float:
    used_s, begun_s = time.process_time(), time.monotonic()
    time.sleep(seconds)
    return (time.process_time() - used_s) / (time.monotonic() - begun_s)


def _stays(moved: int) -> str:
    return f"moved {moved} times" if moved else "stays"


def _silent(rng: Rng) -> float:
    """From its last byte on."""
    with _driven(rng) as rig:
        offset = float(rng.integers(0, _REPORT_BYTES + 1))
        rig.device = FaultyWire(rig.robot, SIP, Fault("robot", "off", offset), rng, time.monotonic_ns())
        injected_ns = time.monotonic_ns()
        rig.wait(lambda: rig.is_lost and rig.failed_ns > injected_ns)
        return (rig.failed_ns - rig.said_ns) / 1e9


def _noise(rngs: List[Rng]) -> List[FaultRow]:
    runs = [noisy_drive(rng, NOISY_PACKETS, 0.01) for rng in rngs]
    intact, kept = sum(run.intact for run in runs), sum(run.kept for run in runs)
    implausible, share = sum(run.implausible for run in runs), kept / intact
    remark = f"{100 * share:.3f} % of {intact} intact packets kept, {implausible} implausible states"
    aim = "99.9 % kept, none implausible"
    return [FaultRow("R3", "1 % of the bytes are noise", aim, math.inf, [], remark, share < 0.999 or implausible > 0)]


def _started_anew(rngs: List[Rng]) -> List[FaultRow]:
    seconds: List[float] = []
    moved = enabled = 0
    jumps: List[float] = []
    for rng in rngs:
        with _driven(rng) as rig:
            injected_ns, before = time.monotonic_ns(), _pose(rig)
            rig.robot.power_cycle(injected_ns)
            rig.wait(lambda: rig.is_lost)
            rig.drives = False
            rig.wait(lambda: not rig.is_lost)
            seconds.append((time.monotonic_ns() - injected_ns) / 1e9)
            time.sleep(_STAYS_S)
            after = _pose(rig)
            jumps.append(math.dist((before.x_m, before.y_m), (after.x_m, after.y_m)))
            moved += rig.moved_since(injected_ns + 300_000_000)
            enabled += rig.robot.drive.motors
    bad = moved > 0 or enabled > 0 or max(jumps) > _CONTINUOUS_M
    remark = f"{_stays(moved)}, motors {'on' if enabled else 'off'}, pose within {100 * max(jumps):.0f} cm"
    return [FaultRow("R4", "power off for 0.5 s, until it reports again", "3 s", 3.0, seconds, remark, bad)]


def _pose(rig: Rig) -> Pose2D:
    report = rig.thread.news.newest
    if report is None:
        raise RuntimeError("R4: expected a robot that reports, got none")
    return report.state.odometry


def _not_read(rngs: List[Rng]) -> List[FaultRow]:
    seconds: List[float] = []
    late: List[float] = []
    for rng in rngs:
        with _driven(rng) as rig:
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


def _jammed(rng: Rng) -> float:
    with _driven(rng) as rig:
        injected_ns, rig.body.jammed = time.monotonic_ns(), True
        rig.body.halt()
        return rig.stopped_after_s(injected_ns)


def _bump(rig: Rig) -> None:
    rig.body.bumpers = (False, True, False, False, False), UNTOUCHED


def _press(rig: Rig) -> None:
    rig.robot.e_stop_pressed = True


def _switch_off(rig: Rig) -> None:
    rig.robot.drive.motors = False


def _unwell(rngs: List[Rng]) -> List[FaultRow]:
    faults = (("a bumper", _bump), ("the emergency stop", _press), ("motors switched off", _switch_off))
    return [
        FaultRow("R8", f"{what}, until told to stop", "a cycle and 50 ms", 0.15, [_told(rng, inject) for rng in rngs])
        for what, inject in faults
    ]


def _told(rng: Rng, inject: Callable[[Rig], None]) -> float:
    with _driven(rng) as rig:
        injected_ns = time.monotonic_ns()
        inject(rig)
        return rig.stopped_after_s(injected_ns)


def _second_instance(rngs: List[Rng]) -> List[FaultRow]:
    seconds: List[float] = []
    wrong = lost = 0
    for rng in rngs:
        with _driven(rng) as rig:
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
