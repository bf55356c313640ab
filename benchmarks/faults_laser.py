# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the laser, in real time over ptys: from the injection to the first zero that the robot hears."""

from __future__ import annotations

import math
from typing import Callable, List, Literal, Tuple

import numpy as np
from benchmarks.fault_lab import FaultLab
from benchmarks.fault_row import FaultRow
from benchmarks.faults_laser_noise import NoisyStream, noisy_stream

from edgefusion.clock import system_clock

Speed = Literal[38400, 500000]
SPEEDS: Tuple[Speed, ...] = (500000, 38400)
TELEGRAMS = 5000
"""Each seed's; of twenty seeds a hundred thousand."""

_SCAN_S, _SLACK_S = 0.02667, 0.05


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """tick: called after every drive."""

    def stops(fault: str, baudrate: Speed = 500000) -> List[float]:
        seconds = []
        for seed in range(seeds):
            with FaultLab(seed, baudrate) as lab:
                lab.driving()
                seconds.append(lab.stopped_after_s(lab.inject(fault)))
            tick()
        return seconds

    unplugged = {baudrate: _unplugged(seeds, baudrate, tick) for baudrate in SPEEDS}
    return [
        FaultRow("L1", "laser off, 500000 baud", "STOP in 200 ms", 0.2, stops("laser=off")),
        FaultRow("L1", "laser off, 38400 baud", "STOP in 530 ms", 0.53, stops("laser=off", 38400)),
        *(
            row
            for baudrate, (stopped, back) in unplugged.items()
            for row in (
                FaultRow("L2", f"laser unplugged, {baudrate} baud", "STOP in 100 ms", 0.1, stopped),
                FaultRow("L2", f"plugged in again, {baudrate} baud", "good in 1 s", 1.0, back),
            )
        ),
        FaultRow("L2", "laser off in mid-telegram", "STOP in 200 ms", 0.2, stops("laser=off:300")),
        FaultRow("L3", "laser repeats itself", "STOP in 5 scans + 50 ms", 5 * _SCAN_S + _SLACK_S, stops("laser=stuck")),
        FaultRow("L4", "1 % of the laser's bytes are noise", "STOP in 200 ms", 0.2, stops("laser=garbage:0.01")),
        *(_noise(seeds, error) for error in (0.0001, 0.001, 0.01)),
        FaultRow("L5", "laser covered", "STOP in 2 scans", 3 * _SCAN_S + _SLACK_S, _covered(seeds, tick)),
        FaultRow("L6", "scans 0.3 s late", "STOP in the age limit + 50 ms", 0.22, stops("laser=delayed:0.3")),
    ]


def _unplugged(seeds: int, baudrate: Speed, tick: Callable[[], object]) -> Tuple[List[float], List[float]]:
    """Until the first zero, and until all is well after it is plugged in again."""
    stopped, back = [], []
    for seed in range(seeds):
        with FaultLab(seed, baudrate) as lab:
            lab.driving()
            stopped.append(lab.stopped_after_s(lab.unplug_laser()))
            lab.wait_for(lambda: not _laser_well(lab))
            lab.plug_laser()
            back.append(lab.wait_for(lambda: _laser_well(lab)))
        tick()
    return stopped, back


def _noise(seeds: int, error: float) -> FaultRow:
    """Without a robot: as many telegrams as it takes to meet one that is false and has the right checksum."""
    run = sum((noisy_stream(np.random.default_rng(seed), TELEGRAMS, error) for seed in range(seeds)), NoisyStream())
    what = f"{100 * error:g} % of the bytes of {seeds * TELEGRAMS} telegrams are noise"
    remark = (
        f"{run.kept} of {run.intact} intact ones read, {run.used} on a good line; "
        f"{run.false} false ones read, {run.driven_by} on a good line"
    )
    bad = run.kept < 0.99 * run.intact or run.driven_by > 0
    return FaultRow("L4", what, "99 % of the intact read, none false driven by", math.inf, [], remark, bad)


def _covered(seeds: int, tick: Callable[[], object]) -> List[float]:
    """The first scan that is covered may have begun before: two whole ones and a rest."""
    seconds = []
    for seed in range(seeds):
        with FaultLab(seed) as lab:
            lab.driving()
            since_ns = system_clock()
            lab.devices.laser.covered = True
            seconds.append(lab.stopped_after_s(since_ns))
        tick()
    return seconds


def _laser_well(lab: FaultLab) -> bool:
    healths = lab.outputs[-1].healths if lab.outputs else ()
    return any(health.component == "laser" and health.state.value == "ok" for health in healths)
