# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A body on an endless floor, whose time goes on when it is told: for firmware that is to be tested alone."""

from __future__ import annotations

import math
from typing import Dict

from edgefusion.sim.robot import SimBase
from edgefusion.types import Pose2D, Twist2D

UNTOUCHED = (False,) * 5


class FloorBody:
    """stalled, bumpers, echoes [m] by sonar: what it tells, which nothing but its user changes. jammed: its wheels do
    not turn, and nothing says so. base: what is to be stepped."""

    def __init__(self) -> None:
        self.base = SimBase()
        self.stalled = (False, False)
        self.bumpers = (UNTOUCHED, UNTOUCHED)
        self.jammed = False
        self.echoes: Dict[int, float] = {}

    @property
    def odometry(self) -> Pose2D:
        """Where its wheels have brought it."""
        return self.base.odometry

    @property
    def twist(self) -> Twist2D:
        """How fast its wheels are."""
        return self.base.twist

    def command(self, twist: Twist2D) -> None:
        """The velocity to reach and keep; none while it is stalled or jammed."""
        self.base.command(Twist2D() if self.jammed or any(self.stalled) else twist)

    def halt(self) -> None:
        """Stands at once."""
        self.base.command(Twist2D())
        self.base.twist = Twist2D()

    def sonar_m(self, number: int) -> float:
        """Its echo; inf where it has none."""
        return self.echoes.get(number, math.inf)
