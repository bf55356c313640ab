# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""R4, R7 and R8 in real time: a robot that starts anew, does not do what it is told, or says that it must not drive."""

from __future__ import annotations

import math
import time
from typing import Callable, List

from benchmarks.fault_row import FaultRow
from benchmarks.faults_robot_rig import Rig, Rng, driven, stays

from edgefusion.sim.floor_body import UNTOUCHED
from edgefusion.types import Pose2D

_STAYS_S, _CONTINUOUS_M = 1.0, 0.04


def started_anew(rngs: List[Rng]) -> List[FaultRow]:
    """R4."""
    seconds: List[float] = []
    moved = enabled = 0
    jumps: List[float] = []
    for rng in rngs:
        with driven(rng) as rig:
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
    remark = f"{stays(moved)}, motors {'on' if enabled else 'off'}, pose within {100 * max(jumps):.0f} cm"
    return [FaultRow("R4", "power off for 0.5 s, until it reports again", "3 s", 3.0, seconds, remark, bad)]


def _pose(rig: Rig) -> Pose2D:
    report = rig.thread.news.newest
    if report is None:
        raise RuntimeError("R4: expected a robot that reports, got none")
    return report.state.odometry


def jammed(rngs: List[Rng]) -> List[FaultRow]:
    """R7."""
    seconds = [_jammed_after_s(rng) for rng in rngs]
    return [FaultRow("R7", "wheels that do not turn, until told to stop", "1.1 s", 1.1, seconds)]


def _jammed_after_s(rng: Rng) -> float:
    with driven(rng) as rig:
        injected_ns, rig.body.jammed = time.monotonic_ns(), True
        rig.body.halt()
        return rig.stopped_after_s(injected_ns)


def _bump(rig: Rig) -> None:
    rig.body.bumpers = (False, True, False, False, False), UNTOUCHED


def _press(rig: Rig) -> None:
    rig.robot.e_stop_pressed = True


def _switch_off(rig: Rig) -> None:
    rig.robot.drive.motors = False


def unwell(rngs: List[Rng]) -> List[FaultRow]:
    """R8."""
    faults = (("a bumper", _bump), ("the emergency stop", _press), ("motors switched off", _switch_off))
    return [
        FaultRow("R8", f"{what}, until told to stop", "a cycle and 50 ms", 0.15, [_told(rng, inject) for rng in rngs])
        for what, inject in faults
    ]


def _told(rng: Rng, inject: Callable[[Rig], None]) -> float:
    with driven(rng) as rig:
        injected_ns = time.monotonic_ns()
        inject(rig)
        return rig.stopped_after_s(injected_ns)
