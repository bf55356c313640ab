# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The control law: a way down a potential becomes a velocity that a differential base can drive.

It cannot move sideways, so it turns towards where u = -k grad U (4) points, and goes forward with what of u lies ahead
of it, times the cosine once more: with the plain component it swings wide around near goals that lie beside it.
Whose gradient it is does not matter here: any field's direction and speed will do.
"""

from __future__ import annotations

import math
from typing import Iterable

from edgefusion.config import BaseConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.braking import stoppable_speed
from edgefusion.types import Goal, Twist2D

TURN_GAIN = 2.0
"""Yaw rate by how far off the direction is [1/s]; above the gain by which the goal is approached, or it is circled."""

CYCLE_S = 0.05
"""How long a command holds."""

_LEAST_YAW_RATE = math.radians(1)
_SETTLED_M = 0.02


def drive(direction_xy: Iterable[float], speed_mps: float, base: BaseConfig) -> Twist2D:
    """The velocity that follows a direction of base_link (x, y) of any length, at this speed once it is faced.

    No forward speed where it points behind: the robot turns first. A direction of no length stands still. Raises
    RefusedError for what is not finite, or a speed below 0.
    """
    x, y = (float(value) for value in direction_xy)
    if not (math.isfinite(x) and math.isfinite(y) and 0 <= speed_mps < math.inf):
        raise RefusedError(f"drive: expected a finite direction and speed, got ({x}, {y}) and {speed_mps}")
    length = math.hypot(x, y)
    if length == 0 or speed_mps == 0:
        return Twist2D()
    ahead = max(x / length, 0.0)
    return Twist2D(min(speed_mps, base.max_speed_mps) * ahead * ahead, _yaw_rate(math.atan2(y, x), base))


def approach_speed_mps(way_left_m: float, base: BaseConfig) -> float:
    """How fast the base may be that stops where the way ends, after the time that a command takes and holds."""
    return stoppable_speed(way_left_m, base.command_delay_s + CYCLE_S, base.acceleration_mps2)


def turn(angle: float, base: BaseConfig) -> Twist2D:
    """The velocity of a turn on the spot, left positive [rad]: never too slow for the wire, unless it is done."""
    rate = _yaw_rate(angle, base)
    least = min(_LEAST_YAW_RATE, base.max_yaw_rate_radps)
    return Twist2D(0.0, math.copysign(max(abs(rate), least), angle)) if angle else Twist2D()


def is_there(distance_m: float, was_there: bool, goal: Goal) -> bool:
    """Whether the goal's place is reached. It is a little within the tolerance, and is not left before that ends: the
    turn to the goal's heading must not push the robot out again."""
    settled_m = min(goal.position_tolerance_m / 2, _SETTLED_M)
    return distance_m <= goal.position_tolerance_m - (0.0 if was_there else settled_m)


def as_carried(twist: Twist2D) -> Twist2D:
    """What the wire carries of it: whole mm/s and whole deg/s, never faster than it was."""
    return Twist2D(_whole(twist.v_mps * 1000) / 1000, math.radians(_whole(math.degrees(twist.w_radps))))


def _yaw_rate(angle: float, base: BaseConfig) -> float:
    """Proportional to the angle, so slow that the turn can still be ended there, and within the base's limit."""
    stoppable = stoppable_speed(abs(angle), base.command_delay_s + CYCLE_S, base.yaw_acceleration_radps2)
    return math.copysign(min(TURN_GAIN * abs(angle), stoppable, base.max_yaw_rate_radps), angle)


def _whole(value: float) -> int:
    """Towards zero; what was whole stays it, however floats round."""
    return math.trunc(value + math.copysign(1e-6, value))
