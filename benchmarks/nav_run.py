# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One drive to a goal in a simulated floor plan, commanded at 20 Hz, and how it ended; many of them at once."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from enum import Enum
from typing import Any, Callable, Iterable, List, Protocol, Sequence, TypeVar

import numpy as np
import numpy.typing as npt
from tqdm import tqdm

from edgefusion.config import BaseConfig
from edgefusion.navigation.progress import Progress, State
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.plan_simulation import PlanSimulation, PlanSpec
from edgefusion.sim.robot import BaseSpec
from edgefusion.types import Goal, Pose2D, Scan, Twist2D

Floats = npt.NDArray[np.float64]
Job = TypeVar("Job")
Result = TypeVar("Result")

TICK_NS = 50_000_000
STOOD_NS = 300_000_000
"""A robot that has stood for so long did not drive into what touches it."""

_NS_PER_S = 1e9


class Navigates(Protocol):
    """What is measured: edgefusion's Navigator, or a peer."""

    def step(self, stamp_ns: int, scan: Scan | None, pose: Pose2D, goal: Goal) -> tuple[Twist2D, Progress]: ...


class Outcome(str, Enum):
    """ELSEWHERE: the navigator took a place for the goal that is not. WALKED_INTO: something touched a robot that had
    stood for STOOD_NS."""

    REACHED = "reached"
    ELSEWHERE = "arrived elsewhere"
    BLOCKED = "blocked"
    CONTACT = "contact"
    WALKED_INTO = "walked into"
    TIMEOUT = "timeout"


@dataclass(frozen=True)
class Run:
    """reason: of BLOCKED, else empty. clearance_m: the smallest between hull and plan. path: true poses at every
    command, float64[n, 3]."""

    outcome: Outcome
    reason: str
    time_s: float
    clearance_m: float
    path: Floats

    @property
    def way_m(self) -> float:
        """How far it drove."""
        return float(np.hypot(*np.diff(self.path[:, :2], axis=0).T).sum())

    def record(self) -> dict[str, Any]:
        """Plain values, without the path."""
        return {
            "outcome": self.outcome.value,
            "reason": self.reason,
            "time_s": round(self.time_s, 2),
            "clearance_m": round(self.clearance_m, 4),
            "way_m": round(self.way_m, 2),
        }


There = Callable[[PlanSimulation], bool]
"""Whether the robot is where it should get to."""


def drive(
    sim: PlanSimulation, navigator: Navigates, goal: Goal, limit_s: float, there: There, at_once: bool = False
) -> Run:
    """Drives until the navigator is done with the goal, a contact, or the time is over.

    at_once: reached as soon as it is there, whether or not the navigator has more to do.
    """
    path, ending = [sim.pose], None
    while ending is None:
        twist, progress = navigator.step(sim.stamp_ns, sim.newest_scan(), sim.odometry, goal)
        ending = _ending(sim, progress, limit_s, there, at_once)
        if ending is None:
            sim.command(twist)
            sim.step_to(sim.stamp_ns + TICK_NS)
            path.append(sim.pose)
    reason = progress.reason.value if ending is Outcome.BLOCKED and progress.reason else ""
    poses = np.array([(pose.x_m, pose.y_m, pose.theta) for pose in path])
    return Run(ending, reason, sim.stamp_ns / _NS_PER_S, sim.clearance_m, poses)


def _ending(sim: PlanSimulation, progress: Progress, limit_s: float, there: There, at_once: bool) -> Outcome | None:
    """How the drive has ended; None where it goes on."""
    if sim.contact:
        return Outcome.WALKED_INTO if sim.standing_ns >= STOOD_NS else Outcome.CONTACT
    if at_once and there(sim):
        return Outcome.REACHED
    if progress.state is State.ARRIVED:
        return Outcome.REACHED if there(sim) else Outcome.ELSEWHERE
    if progress.state is State.BLOCKED:
        return Outcome.BLOCKED
    return Outcome.TIMEOUT if sim.stamp_ns >= limit_s * _NS_PER_S else None


def plan_spec(
    base: BaseConfig, laser: LaserSpec, wheels_percent: float = 0.0, slip_m: float = 0.0, **options: Any
) -> PlanSpec:
    """The simulated base that does what the configured one is told to be able to.

    wheels_percent: how much farther than counted the wheels go; slip_m: BaseSpec's. options: PlanSpec's others.
    """
    drive = BaseSpec(
        base.max_speed_mps,
        base.max_yaw_rate_radps,
        base.acceleration_mps2,
        base.yaw_acceleration_radps2,
        slip_m=slip_m,
        left_drift_percent=wheels_percent,
        right_drift_percent=wheels_percent,
    )
    delay_ns = round(base.command_delay_s * _NS_PER_S)
    return PlanSpec(base.footprint_m, drive, laser, Pose2D(*base.laser_pose), command_delay_ns=delay_ns, **options)


def every(work: Callable[[Job], Result], jobs: Sequence[Job], processes: int, title: str) -> List[Result]:
    """The results of all jobs in their order, from so many processes, with a progress bar."""
    with ProcessPoolExecutor(processes) as pool:
        results: Iterable[Result] = tqdm(pool.map(work, jobs), desc=title, total=len(jobs), unit="run")
        return list(results)
