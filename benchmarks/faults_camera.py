# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of the camera's faults in real time: C1 to C4, from a stream on this machine through the real driver."""

from __future__ import annotations

import os
import signal
import time
from typing import Callable, List

from benchmarks.fault_row import FaultRow
from benchmarks.faults_camera_rig import MAX_AGE_S, CameraRig, capturing

from edgefusion.service.cadence import Cadence

_LATER_S = 0.5
_LOOP_NS = 50_000_000
_BLIND = (("black", "camera=wrong"), ("covered", "camera=wrong:0.4"), ("white", "camera=wrong:1"))

Tick = Callable[[], object]


def rows(seeds: int, tick: Tick = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each drive of them."""
    return [
        *_unplugged(seeds, tick),
        _told("C1", "silent, until lost", "camera=off", "CAMERA_LOST", 0.5, seeds, tick),
        _told("C2", "the same picture, until frozen", "camera=stuck", "CAMERA_FROZEN", 1.0, seeds, tick),
        *[_told("C3", f"{what}, until blind", fault, "CAMERA_BLIND", 1.0, seeds, tick) for what, fault in _BLIND],
        *_hanging(seeds, tick),
    ]


def _unplugged(seeds: int, tick: Tick) -> List[FaultRow]:
    lost: List[float] = []
    back: List[float] = []
    for seed in range(seeds):
        with CameraRig(seed) as rig:
            begin_s = time.monotonic()
            rig.unplug()
            rig.wait_for(lambda: rig.says("CAMERA_LOST"))
            lost.append(time.monotonic() - begin_s)
            rig.given_within(_LATER_S + 0.1 * seed)
            rig.plug()
            back.append(rig.wait_for(lambda: rig.is_well))
        tick()
    return [
        FaultRow("C1", "unplugged, until lost", "500 ms", 0.5, lost),
        FaultRow("C1", "plugged in again, until well", "3 s", 3.0, back),
    ]


def _told(figure: str, what: str, fault: str, code: str, limit_s: float, seeds: int, tick: Tick) -> FaultRow:
    seconds: List[float] = []
    oldest_s, given = 0.0, 0
    for seed in range(seeds):
        with CameraRig(seed) as rig:
            rig.inject(fault)
            seconds.append(rig.wait_for(lambda: rig.says(code)))
            given += rig.given_within(_LATER_S)
            oldest_s = max(oldest_s, rig.oldest_s)
        tick()
    remark, failed = _aged(oldest_s)
    return FaultRow(
        figure, what, f"{limit_s:g} s", limit_s, seconds, f"{given} pictures given after; {remark}", failed or given > 0
    )


def _aged(oldest_s: float) -> tuple[str, bool]:
    return f"none older than {1e3 * oldest_s:.0f} ms looked at", oldest_s > MAX_AGE_S + 0.005


def _hanging(seeds: int, tick: Tick) -> List[FaultRow]:
    """The process that reads stands still, as one that hangs in the kernel does."""
    back: List[float] = []
    late: List[float] = []
    for seed in range(seeds):
        with CameraRig(seed) as rig:
            (reader,) = capturing()
            os.kill(reader, signal.SIGSTOP)
            begin_s, loop = time.monotonic(), Cadence(_LOOP_NS, time.monotonic_ns, time.sleep)
            while not rig.says("CAMERA_LOST") or reader in capturing():
                loop.next()
                rig.ask()
            while not rig.is_well:
                loop.next()
                rig.ask()
            back.append(time.monotonic() - begin_s)
            late.append(loop.lateness.p99_ms / 1e3)
        tick()
    return [
        FaultRow("C4", "its reader hangs, until it reads again", "5 s", 5.0, back),
        FaultRow("C4", "a loop of 20 Hz meanwhile, 99 of 100 cycles late by", "20 ms", 0.02, late),
    ]
