# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One world in the time of the caller's clock: a robot's body in it, and what its laser sees."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np

from edgefusion.config.navigation import P3DX_FOOTPRINT_M
from edgefusion.pose_history import SPAN_NS
from edgefusion.sim.built_world import build
from edgefusion.sim.hull import bounded
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.live_body import LiveBody
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import BaseSpec
from edgefusion.sim.world import World
from edgefusion.types import Pose2D, Scan


class LiveWorld:
    """The world of a file from its start, and the body that is driven in it. Nothing happens between two step_to()."""

    def __init__(
        self,
        world: World,
        now_ns: int,
        seed: int = 0,
        rig: Rig | None = None,
        spec: BaseSpec | None = None,
        corners_m: Sequence[Tuple[float, float]] = P3DX_FOOTPRINT_M,
    ) -> None:
        self.rig = rig or Rig()
        self._rng = np.random.default_rng(seed)
        self._begin_ns = now_ns
        built = build(world, self.rig.laser_height_m)
        self._segments = built.plan.segments
        # The floor plan is a cut at the laser's height: what is lower or higher is met by nothing here.
        self.body = LiveBody(spec or BaseSpec(), world.start, bounded(self._segments), corners_m, now_ns)

    def step_to(self, now_ns: int) -> None:
        """Lets the time pass until then."""
        self.body.step_to(now_ns)

    def scan_at(self, stamp_ns: int, spec: LaserSpec) -> Scan:
        """What such a laser measured, its middle beam then. Of times more than a second ago, or before the world's
        begin, it is what it measured at the first that there is."""
        newest_ns = self.body.stamp_ns
        oldest_ns = max(self._begin_ns, newest_ns - SPAN_NS)

        def pose_at(ns: int) -> Pose2D:
            return self.rig.laser_pose(self.body.pose_at(min(max(ns, oldest_ns), newest_ns)))

        return SimLaser(spec).scan(stamp_ns, self._segments, pose_at, self._rng)[0]
