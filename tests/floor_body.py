# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A body on an endless floor, whose time goes on when it is told."""

from __future__ import annotations

import math

from edgefusion.sim.robot import SimBase
from edgefusion.types import Pose2D, Twist2D

UNTOUCHED = (False,) * 5


class FloorBody:
    """stalled, bumpers, echoes: what a test may change."""

    def __init__(self) -> None:
        self.base = SimBase()
        self.stalled = (False, False)
        self.bumpers = (UNTOUCHED, UNTOUCHED)
        self.echoes: dict[int, float] = {}

    @property
    def odometry(self) -> Pose2D:
        return self.base.odometry

    @property
    def twist(self) -> Twist2D:
        return self.base.twist

    def command(self, twist: Twist2D) -> None:
        self.base.command(Twist2D() if any(self.stalled) else twist)

    def halt(self) -> None:
        self.base.command(Twist2D())
        self.base.twist = Twist2D()

    def sonar_m(self, number: int) -> float:
        return self.echoes.get(number, math.inf)
