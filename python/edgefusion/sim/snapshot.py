# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One look at a world from a robot that drives: a scan, a frame a little earlier or later, and what is there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.exposure import CameraSpec, exposed
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.light import Light
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.truth import ObjectTruth, truth_of
from edgefusion.types import Frame, Pose2D, Scan, Twist2D

Rng = np.random.Generator

SCAN_NS = 1_000_000_000
"""When the scan of a snapshot is taken; the frame's stamp is up to FRAME_APART_NS from it."""

FRAME_APART_NS = 50_000_000
_NS_PER_S = 1e9


@dataclass(frozen=True)
class Snapshot:
    """scan, frame: what the sensors deliver. motion: from the scan's stamp to the frame's, by odometry. owners:
    int32[beams], whose surface each beam met (FloorPlan.owners_of). truth: at the frame's stamp."""

    scan: Scan
    frame: Frame
    motion: Pose2D
    owners: npt.NDArray[np.int32]
    truth: tuple[ObjectTruth, ...]


def snapshot(
    world: BuiltWorld, renderer: Renderer, rig: Rig, base: Pose2D, twist: Twist2D, light: Light, rng: Rng
) -> Snapshot:
    """A look from `base`, where the robot is at the scan's stamp, driving on; the renderer shows the world."""
    frame_ns = SCAN_NS + int(rng.integers(-FRAME_APART_NS, FRAME_APART_NS + 1))

    def base_at(stamp_ns: int) -> Pose2D:
        return base.compose(twist.motion((stamp_ns - SCAN_NS) / _NS_PER_S))

    laser = SimLaser(LaserSpec())
    scan, hits = laser.scan(SCAN_NS, world.plan.segments, lambda ns: rig.laser_pose(base_at(ns)), rng)
    clean = renderer.image(base_at(frame_ns), light)
    image = exposed(CameraSpec(), clean, float(rig.K[0, 0]), twist.w_radps, rng)
    return Snapshot(
        scan=scan,
        frame=Frame(frame_ns, image),
        motion=twist.motion((frame_ns - scan.stamp_ns) / _NS_PER_S),
        owners=world.plan.owners_of(hits),
        truth=tuple(truth_of(world, renderer, rig, base_at(frame_ns), hits)),
    )
