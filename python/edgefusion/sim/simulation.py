# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One world in simulated time: the base drives, the laser scans it, the camera sees it, as fast as they can.

Scans and frames come at the pace of the real sensors and are made when somebody asks for them. What a scan or a frame
holds depends on the seed, its stamp and the commands before it, not on which others were asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from edgefusion.clock import SimClock
from edgefusion.errors import RefusedError
from edgefusion.pose_history import PoseHistory
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.exposure import CameraSpec, balance, exposed
from edgefusion.sim.laser import Hits, LaserSpec, SimLaser
from edgefusion.sim.light import random_light
from edgefusion.sim.pace import Pace
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.sim.truth import ObjectTruth, truth_of
from edgefusion.types import Frame, Pose2D, Scan, Twist2D

STEP_NS = 10_000_000
"""The base is integrated in steps of this length."""

_NS_PER_S = 1e9
_SCAN, _FRAME, _PHASE, _LIGHT, _BALANCE = range(5)


@dataclass(frozen=True)
class SensorSpec:
    """Laser and camera. One drive has one light, and one gain and tint, as a camera with a fixed exposure has.

    line_ns: a telegram of 361 ranges on a line of 500 kbaud. frame_period_ns: of the camera. transfer_ns: from the
    middle of a frame's exposure to the frame in memory.
    """

    laser: LaserSpec = field(default_factory=LaserSpec)
    camera: CameraSpec = field(default_factory=CameraSpec)
    line_ns: int = 14_640_000
    frame_period_ns: int = 33_333_333
    transfer_ns: int = 40_000_000

    def __post_init__(self) -> None:
        if self.laser.turn_ns < 1:
            raise RefusedError(f"turn_ns: expected at least 1 for repeated scans, got {self.laser.turn_ns}")
        if self.frame_period_ns < 1:
            raise RefusedError(f"frame_period_ns: expected at least 1, got {self.frame_period_ns}")
        for name in ("line_ns", "transfer_ns"):
            if getattr(self, name) < 0:
                raise RefusedError(f"{name}: expected at least 0, got {getattr(self, name)}")


class Simulation:
    """A base with a laser, and a camera where there is a renderer, in a built world, from its start.

    The clock is the simulation's own: stamps begin at 0. Poses are the world's, odometry begins at Pose2D().
    """

    def __init__(
        self,
        world: BuiltWorld,
        rig: Rig,
        renderer: Renderer | None,
        seed: int,
        base: BaseSpec | None = None,
        sensors: SensorSpec | None = None,
    ) -> None:
        self.world, self.rig, self.clock = world, rig, SimClock()
        self._renderer, self._seed, self._sensors = renderer, seed, sensors or SensorSpec()
        self._base = SimBase(base or BaseSpec(), world.world.start, seed)
        self._believed = PoseHistory()
        self._believed.add(self.stamp_ns, self.odometry)
        self._laser = SimLaser(self._sensors.laser)
        self._light = random_light(self._rng(_LIGHT))
        self._balance = balance(self._sensors.camera, self._rng(_BALANCE))
        self._scans, self._frames = self._paces()
        if renderer is not None:
            renderer.show(world)

    @property
    def stamp_ns(self) -> int:
        """Now."""
        return self.clock()

    @property
    def pose(self) -> Pose2D:
        """Where the base really is."""
        return self._base.pose

    @property
    def odometry(self) -> Pose2D:
        """Where the base believes to be, from where it started."""
        return self._base.odometry

    def command(self, twist: Twist2D) -> None:
        """The velocity to drive with from now on."""
        self._base.command(twist)

    def step_to(self, stamp_ns: int) -> None:
        """Lets the time pass until then."""
        while self.stamp_ns < stamp_ns:
            dt_ns = min(STEP_NS, stamp_ns - self.stamp_ns)
            self._base.step(dt_ns)
            self._believed.add(self.clock.advance(dt_ns), self.odometry)

    def pose_at(self, stamp_ns: int) -> Pose2D:
        """Where the base really was at a time within the last second. Raises RefusedError for any other."""
        return self._base.pose_at(stamp_ns)

    def odometry_at(self, stamp_ns: int) -> Pose2D:
        """Where the base believed to be then. Raises RefusedError for a time that is not within the last second."""
        return self._believed.at(stamp_ns)

    def scan_stamps(self, after_ns: int) -> list[int]:
        """The stamps of the scans that have come by now, of those after a time."""
        return self._scans.since(after_ns, self.stamp_ns)

    def frame_stamps(self, after_ns: int) -> list[int]:
        """The same of the frames."""
        return self._frames.since(after_ns, self.stamp_ns)

    def scan(self, stamp_ns: int) -> Scan:
        """The scan of one of the laser's stamps."""
        return self._scan(stamp_ns)[0]

    def owners(self, stamp_ns: int) -> npt.NDArray[np.int32]:
        """Whose surface each beam of that scan met, int32[beams]: an object's index, BUILDING or NOTHING_MET."""
        return self.world.plan.owners_of(self._scan(stamp_ns)[1])

    def frame(self, stamp_ns: int) -> Frame:
        """The frame of one of the camera's stamps. Raises RefusedError where there is no renderer."""
        rng = self._rng(_FRAME, self._frames.index(stamp_ns))
        clean = self._camera().image(self.pose_at(stamp_ns), self._light)
        half_ns = self._sensors.camera.exposure_ns // 2
        turn = self.pose_at(stamp_ns + half_ns).relative_to(self.pose_at(stamp_ns - half_ns)).theta
        yaw_rate = turn / (2 * half_ns / _NS_PER_S)
        focal_px = float(self.rig.K[0, 0])
        return Frame(stamp_ns, exposed(self._sensors.camera, clean, focal_px, yaw_rate, rng, self._balance))

    def truth(self, scan_ns: int, frame_ns: int) -> list[ObjectTruth]:
        """The objects that both this scan and this frame show, nearest first, where they were at the frame's stamp.

        Raises RefusedError where there is no renderer.
        """
        return truth_of(self.world, self._camera(), self.rig, self.pose_at(frame_ns), self._scan(scan_ns)[1])

    def _scan(self, stamp_ns: int) -> tuple[Scan, Hits]:
        rng = self._rng(_SCAN, self._scans.index(stamp_ns))
        segments = self.world.plan.segments
        return self._laser.scan(stamp_ns, segments, lambda ns: self.rig.laser_pose(self.pose_at(ns)), rng)

    def _camera(self) -> Renderer:
        if self._renderer is None:
            raise RefusedError("camera: this simulation has no renderer")
        return self._renderer

    def _rng(self, *what: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, *what])

    def _paces(self) -> tuple[Pace, Pace]:
        """Neither sensor knows of the other: when in its period each begins is drawn."""
        rng, sensors = self._rng(_PHASE), self._sensors
        before_ns, after_ns = -int(self._laser.beam_dt_ns.min()), int(self._laser.beam_dt_ns.max())
        turns = 2 if sensors.laser.interlaced else 1
        scan_ns, frame_ns = turns * sensors.laser.turn_ns, sensors.frame_period_ns
        first_scan_ns = before_ns + int(rng.integers(scan_ns))
        first_frame_ns = sensors.camera.exposure_ns // 2 + int(rng.integers(frame_ns))
        return (
            Pace(first_scan_ns, scan_ns, after_ns + sensors.line_ns),
            Pace(first_frame_ns, frame_ns, sensors.transfer_ns),
        )
