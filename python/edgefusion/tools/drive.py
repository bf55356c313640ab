# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A drive through a simulated world, from its start along its route to its goal, with the detector watching."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Iterator, NamedTuple

from edgefusion.config import SyncConfig
from edgefusion.perception.detector import Detector, StageTimes
from edgefusion.perception.sync import Pair, Synchronizer
from edgefusion.sim.floor_plan import distances_m
from edgefusion.sim.route import RouteFollower
from edgefusion.sim.simulation import Simulation
from edgefusion.sim.snapshot import Snapshot
from edgefusion.types import Detection, Pose2D

TICK_NS = 50_000_000
"""The base gets a command 20 times a second."""

LOOK_NS = 250_000_000
"""The detector takes the first frame after so long, of the camera's 30 a second every eighth; only those are
rendered."""

SLOWEST_MPS, PATIENCE_S = 0.05, 60.0
"""A drive that takes longer than its way at this speed, and this more, will not end."""

_NS_PER_S = 1e9

Pacing = Callable[[int], None]
"""Is told the simulation's time at every tick; where somebody watches it waits until that is due."""


class Moment(NamedTuple):
    """Where the base is, and where it believes to be, both in the world; clearance_m: from its middle to the nearest
    surface at the laser's height."""

    stamp_ns: int
    pose: Pose2D
    believed: Pose2D
    clearance_m: float


@dataclass(frozen=True)
class Look:
    """One frame through the detector. number: of the frame in the drive. believed: the base's pose in the world by
    its odometry at the frame's stamp. shot: what the sensors delivered, and the truth. times: the detector's."""

    number: int
    believed: Pose2D
    shot: Snapshot
    detections: list[Detection]
    times: StageTimes


class Drive:
    """Goes through the drive look by look; `trail` and `pairing` fill up as it goes.

    way_m, way_left_m: along the route to the goal, from the start and from here.
    """

    def __init__(self, simulation: Simulation, detector: Detector, sync: SyncConfig, pace: Pacing) -> None:
        world = simulation.world.world
        self._simulation, self._detector, self._pace = simulation, detector, pace
        self._sync = Synchronizer(round(sync.tolerance_s * 1e9), round(sync.horizon_s * 1e9))
        self._start, self._follower = world.start, RouteFollower(world.route, world.goal)
        self.way_m = self.way_left_m = self._follower.way_left_m(world.start)
        self._limit_ns = round((self.way_m / SLOWEST_MPS + PATIENCE_S) * _NS_PER_S)
        self._scan_ns, self._frame_ns = -1, -LOOK_NS  # the newest that were taken
        self.trail: list[Moment] = []

    @property
    def pairing(self) -> dict[str, int]:
        """How many scans and frames ended how."""
        return self._sync.counts

    def __iter__(self) -> Iterator[Look]:
        """Drives until it has arrived. Raises RuntimeError when it does not."""
        number = 0
        while not self._follower.arrived:
            if self._simulation.stamp_ns > self._limit_ns:
                raise RuntimeError(f"the base has not arrived after {self._limit_ns / _NS_PER_S:.0f} s")
            self._tick()
            for pair in self._pairs():
                yield self._look(number, pair)
                number += 1
        self.trail.append(self._moment())

    def _tick(self) -> None:
        """One command, and the time in which it is obeyed."""
        moment = self._moment()
        self.trail.append(moment)
        self.way_left_m = self._follower.way_left_m(moment.believed)
        self._simulation.command(self._follower.step(moment.believed))
        self._simulation.step_to(moment.stamp_ns + TICK_NS)
        self._pace(self._simulation.stamp_ns)

    def _pairs(self) -> list[Pair]:
        """What the sensors delivered since the last time, as far as it is paired."""
        pairs: list[Pair] = []
        for stamp_ns in self._simulation.scan_stamps(self._scan_ns):
            self._scan_ns = stamp_ns
            pairs += self._sync.add_scan(self._simulation.scan(stamp_ns))
        for stamp_ns in self._simulation.frame_stamps(self._frame_ns):
            if stamp_ns >= self._frame_ns + LOOK_NS:
                self._frame_ns = stamp_ns
                pairs += self._sync.add_frame(self._simulation.frame(stamp_ns))
        return pairs

    def _look(self, number: int, pair: Pair) -> Look:
        simulation, (scan, frame) = self._simulation, pair
        before, now = simulation.odometry_at(scan.stamp_ns), simulation.odometry_at(frame.stamp_ns)
        motion = now.relative_to(before)
        detections = self._detector.detect(scan, frame, motion)
        shot = Snapshot(
            scan=scan,
            frame=frame,
            motion=motion,
            owners=simulation.owners(scan.stamp_ns),
            truth=tuple(simulation.truth(scan.stamp_ns, frame.stamp_ns)),
        )
        return Look(number, self._start.compose(now), shot, detections, self._detector.times)

    def _moment(self) -> Moment:
        simulation, pose = self._simulation, self._simulation.pose
        clearance_m = distances_m([(pose.x_m, pose.y_m)], simulation.world.plan.segments).min(initial=math.inf)
        believed = self._start.compose(simulation.odometry)
        return Moment(simulation.stamp_ns, pose, believed, float(clearance_m))
