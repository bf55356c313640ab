# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a Pioneer reports ten times a second, in metres and words."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, Tuple

from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE, Factors
from edgefusion.drivers.sip_status import Status
from edgefusion.types import Pose2D, Twist2D

NOTHING_COUNTS = 5000
"""Range of a sonar that heard no echo."""

_BUMPERS = 5
"""Of a ring, at the front and at the back."""


@dataclass(frozen=True)
class RobotState:
    """One SIP. odometry: in `odom`. sonar_m: by number, of those that fired since the last SIP; inf: no echo.

    front_bumpers: from the left to the right; rear_bumpers: from the right to the left, as the robot counts them. What
    the robot leaves out is None.
    """

    stamp_ns: int
    odometry: Pose2D
    twist: Twist2D
    battery_v: float
    motors_enabled: bool
    e_stop_pressed: bool
    stalled_left: bool
    stalled_right: bool
    front_bumpers: Tuple[bool, ...]
    rear_bumpers: Tuple[bool, ...]
    sonar_m: Dict[int, float] = field(default_factory=dict)
    charging: bool | None = None
    digital_in: int | None = None
    digital_out: int | None = None
    temperature_c: int | None = None

    @property
    def stalled(self) -> bool:
        """Whether a wheel is blocked."""
        return self.stalled_left or self.stalled_right

    @property
    def bumped(self) -> bool:
        """Whether any bumper is pressed."""
        return any(self.front_bumpers) or any(self.rear_bumpers)


def robot_state(status: Status, factors: Factors, odometry: Pose2D, stamp_ns: int) -> RobotState:
    """The state that a SIP reports which came then, at a place that was worked out from it."""
    return RobotState(
        stamp_ns,
        odometry,
        twist_of(status, factors),
        status.battery_dv / 10,
        status.motors_enabled,
        status.e_stop_pressed,
        status.stall_left,
        status.stall_right,
        _bits(status.bumpers_front),
        _bits(status.bumpers_rear),
        {sonar.number: _range_m(sonar.range_counts, factors) for sonar in status.sonars},
        None if status.charge_state in (None, 255) else status.charge_state > 0,
        status.digital_in,
        status.digital_out,
        None if status.temperature_c in (None, -128) else status.temperature_c,
    )


def twist_of(status: Status, factors: Factors) -> Twist2D:
    """How fast the robot says that it is; it measures its turning by itself where it says that, too."""
    left_mps, right_mps = status.left_speed * factors.speed_mps, status.right_speed * factors.speed_mps
    if status.turn_ddps is not None:
        w_radps = math.radians(status.turn_ddps / 10)
    else:
        w_radps = (right_mps - left_mps) * 1e3 / 2 * HALF_WHEEL_BASE
    return Twist2D((left_mps + right_mps) / 2, w_radps)


def _range_m(counts: int, factors: Factors) -> float:
    return math.inf if counts >= NOTHING_COUNTS else counts * factors.range_m


def _bits(bumpers: int) -> Tuple[bool, ...]:
    return tuple(bool(bumpers >> number & 1) for number in range(_BUMPERS))
