# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated robot's firmware drives: a base in a world."""

from __future__ import annotations

from typing import Protocol, Tuple

from edgefusion.types import Pose2D, Twist2D

Pressed = Tuple[bool, ...]


class Body(Protocol):
    """Its time goes on by itself; what it tells is as of now."""

    @property
    def odometry(self) -> Pose2D:
        """Where its wheels have brought it since it was made."""

    @property
    def twist(self) -> Twist2D:
        """How fast its wheels are."""

    @property
    def stalled(self) -> Tuple[bool, bool]:
        """Whether something blocks the left wheel, and the right one."""

    @property
    def bumpers(self) -> Tuple[Pressed, Pressed]:
        """The five at the front, from the left; the five at the back, from the right."""

    def command(self, twist: Twist2D) -> None:
        """The velocity to reach and keep, with the ramps of the base."""

    def halt(self) -> None:
        """Stands at once, without a ramp."""

    def sonar_m(self, number: int) -> float:
        """What a sonar hears; inf: nothing."""
        ...
