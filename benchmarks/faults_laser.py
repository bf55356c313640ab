# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the laser, in real time over ptys: from the injection to the first zero that the robot hears."""

from __future__ import annotations

from typing import Callable, List, Literal

from benchmarks.fault_lab import FaultLab
from benchmarks.fault_row import FaultRow

from edgefusion.clock import system_clock

_SCAN_S, _SLACK_S = 0.02667, 0.05


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """tick: called after every drive."""

    def stops(fault: str, baudrate: Literal[38400, 500000] = 500000) -> List[float]:
        seconds = []
        for seed in range(seeds):
            with FaultLab(seed, baudrate) as lab:
                lab.driving()
                seconds.append(lab.stopped_after_s(lab.inject(fault)))
            tick()
        return seconds

    return [
        FaultRow("L1", "laser off, 500000 baud", "STOP in 200 ms", 0.2, stops("laser=off")),
        FaultRow("L1", "laser off, 38400 baud", "STOP in 530 ms", 0.53, stops("laser=off", 38400)),
        FaultRow("L2", "laser off in mid-telegram, and back", "STOP in 200 ms", 0.2, stops("laser=off:300")),
        FaultRow("L2", "back after the laser speaks again", "good in 1 s", 1.0, _back(seeds, tick)),
        FaultRow("L3", "laser repeats itself", "STOP in 5 scans + 50 ms", 5 * _SCAN_S + _SLACK_S, stops("laser=stuck")),
        FaultRow("L4", "1 % of the laser's bytes are noise", "STOP in 200 ms", 0.2, stops("laser=garbage:0.01")),
        FaultRow("L5", "laser covered", "STOP in 2 scans", 3 * _SCAN_S + _SLACK_S, _covered(seeds, tick)),
        FaultRow("L6", "scans 0.3 s late", "STOP in the age limit + 50 ms", 0.22, stops("laser=delayed:0.3")),
    ]


def _back(seeds: int, tick: Callable[[], object]) -> List[float]:
    seconds = []
    for seed in range(seeds):
        with FaultLab(seed) as lab:
            lab.driving()
            lab.stopped_after_s(lab.inject("laser=off"))
            lab.wait_for(lambda: not _laser_well(lab))
            lab.mend()
            seconds.append(lab.wait_for(lambda: _laser_well(lab)))
        tick()
    return seconds


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
