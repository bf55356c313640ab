# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of the robot's faults in real time: R1 to R4 and R6 to R9, through ptys, threads and processes."""

from __future__ import annotations

import math
from typing import Callable, List

import numpy as np
from benchmarks.fault_row import FaultRow
from benchmarks.faults_robot_line import not_read, second_instance, silent, unplugged
from benchmarks.faults_robot_noise import noisy_drive
from benchmarks.faults_robot_rig import Rng
from benchmarks.faults_robot_state import jammed, started_anew, unwell

NOISY_PACKETS = 50_000
"""Each seed's; of twenty seeds a million."""


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each."""
    rngs = [np.random.default_rng(seed) for seed in range(seeds)]
    found: List[FaultRow] = []
    for figure in _FIGURES:
        found += figure(rngs)
        tick()
    return found


def noisy(rngs: List[Rng]) -> List[FaultRow]:
    """R3."""
    runs = [noisy_drive(rng, NOISY_PACKETS, 0.01) for rng in rngs]
    intact, kept = sum(run.intact for run in runs), sum(run.kept for run in runs)
    implausible, share = sum(run.implausible for run in runs), kept / intact
    remark = f"{100 * share:.3f} % of {intact} intact packets kept, {implausible} implausible states"
    aim = "99.9 % kept, none implausible"
    return [FaultRow("R3", "1 % of the bytes are noise", aim, math.inf, [], remark, share < 0.999 or implausible > 0)]


_FIGURES = (unplugged, silent, noisy, started_anew, not_read, jammed, unwell, second_instance)
