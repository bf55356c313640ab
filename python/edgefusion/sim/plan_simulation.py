# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base with a laser in a floor plan that may move: for many drives, without surfaces, camera or truth of objects.

Scans come at the pace of the laser and its line. What a scan holds depends on the seed, its stamp and the commands
before it, not on which others were asked for. The time ends with the first contact.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Callable, Deque, Tuple, Union

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.sim.hull import Hull, bounded
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.pace import Pace
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.types import STILL, Pose2D, Scan, Twist2D

Floats = npt.NDArray[np.float64]
Plan = Union[Floats, Callable[[int], Floats]]
"""Segments float64[m, 4] in the world [m], or what gives them for a time [ns]."""

STEP_NS = 10_000_000
"""The base is integrated, and the contact checked, in steps of this length."""

WATCHED_M = 0.5
"""Clearances above this are not measured."""

_PHASE, _SCAN = range(2)


@dataclass(frozen=True)
class PlanSpec:
    """A base with a laser.

    hull_m: corners of a convex outline about the axle, in base_link. laser_pose: in base_link. scan_period_ns: from
    scan to scan. line_ns: from a scan's last beam to the scan in memory. command_delay_ns: from a command to the drive
    that follows it. jump_ns, jump: from when on the odometry is moved, and by what, in `odom`.
    """

    hull_m: Tuple[Tuple[float, float], ...]
    base: BaseSpec = field(default_factory=BaseSpec)
    laser: LaserSpec = field(default_factory=LaserSpec)
    laser_pose: Pose2D = STILL
    scan_period_ns: int = 50_000_000
    line_ns: int = 14_640_000
    command_delay_ns: int = 0
    jump_ns: int = 0
    jump: Pose2D = STILL

    def __post_init__(self) -> None:
        if self.scan_period_ns < 1:
            raise RefusedError(f"scan_period_ns: expected at least 1, got {self.scan_period_ns}")
        for name in ("line_ns", "command_delay_ns", "jump_ns"):
            if getattr(self, name) < 0:
                raise RefusedError(f"{name}: expected at least 0, got {getattr(self, name)}")


class PlanSimulation:
    """The base drives from `start` in the plan; odometry begins at Pose2D(), stamps begin at 0.

    clearance_m: the smallest so far between hull and plan, WATCHED_M while it was never smaller; 0 after a contact.
    """

    def __init__(self, plan: Plan, start: Pose2D, spec: PlanSpec, seed: int = 0) -> None:
        self._plan, self._spec, self._seed = plan, spec, seed
        self._base = SimBase(spec.base, start, seed)
        self._laser, self._hull = SimLaser(spec.laser), Hull(spec.hull_m)
        self._commands: Deque[Tuple[int, Twist2D]] = deque()
        self._moved_ns = 0
        before_ns, after_ns = -int(self._laser.beam_dt_ns.min()), int(self._laser.beam_dt_ns.max())
        first_ns = before_ns + int(self._rng(_PHASE).integers(spec.scan_period_ns))
        self._scans = Pace(first_ns, spec.scan_period_ns, after_ns + spec.line_ns)
        self._newest: Scan | None = None
        self._bounded = bounded(self.segments_at(0))
        self.clearance_m = min(WATCHED_M, self._hull.clearance_m(start, self._bounded, WATCHED_M))

    @property
    def stamp_ns(self) -> int:
        """Now."""
        return self._base.stamp_ns

    @property
    def pose(self) -> Pose2D:
        """Where the base really is."""
        return self._base.pose

    @property
    def odometry(self) -> Pose2D:
        """Where the base believes to be."""
        believed = self._base.odometry
        return self._spec.jump.compose(believed) if self.stamp_ns >= self._spec.jump_ns else believed

    @property
    def twist(self) -> Twist2D:
        """How fast the base is."""
        return self._base.twist

    @property
    def contact(self) -> bool:
        """Whether the hull has touched the plan."""
        return self.clearance_m == 0

    @property
    def standing_ns(self) -> int:
        """For how long the base has stood still."""
        return self.stamp_ns - self._moved_ns

    def command(self, twist: Twist2D) -> None:
        """The velocity to drive with, once the delay is over, until the next."""
        self._commands.append((self.stamp_ns + self._spec.command_delay_ns, twist))

    def step_to(self, stamp_ns: int) -> None:
        """Lets the time pass until then, or until a contact."""
        while self.stamp_ns < stamp_ns and not self.contact:
            while self._commands and self._commands[0][0] <= self.stamp_ns:
                self._base.command(self._commands.popleft()[1])
            self._base.step(min(STEP_NS, stamp_ns - self.stamp_ns))
            if self.twist != Twist2D():
                self._moved_ns = self.stamp_ns
            self._check_contact()

    def newest_scan(self) -> Scan | None:
        """The last scan that has come by now; None before the first. Raises RefusedError where it was taken more than a
        second ago: it is made when it is asked for."""
        after_ns = -1 if self._newest is None else self._newest.stamp_ns
        for stamp_ns in self._scans.since(after_ns, self.stamp_ns)[-1:]:
            rng, segments = self._rng(_SCAN, self._scans.index(stamp_ns)), self.segments_at(stamp_ns)
            self._newest = self._laser.scan(stamp_ns, segments, self._laser_pose_at, rng)[0]
        return self._newest

    def segments_at(self, stamp_ns: int) -> Floats:
        """The plan at a time."""
        return self._plan(stamp_ns) if callable(self._plan) else self._plan

    def _laser_pose_at(self, stamp_ns: int) -> Pose2D:
        return self._base.pose_at(stamp_ns).compose(self._spec.laser_pose)

    def _check_contact(self) -> None:
        segments = self.segments_at(self.stamp_ns)
        if segments is not self._bounded.segments:
            self._bounded = bounded(segments)
        elif self.standing_ns:
            return  # nothing has moved
        self.clearance_m = min(self.clearance_m, self._hull.clearance_m(self.pose, self._bounded, self.clearance_m))

    def _rng(self, *what: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, *what])
