# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The velocity that a Pioneer is sent, and when: never one that is old, and never nothing for long."""

from __future__ import annotations

import math

from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE
from edgefusion.drivers.sip_command import Command, command, wheel_speeds
from edgefusion.errors import RefusedError
from edgefusion.types import Twist2D

MAX_AGE_NS = 300_000_000
"""A velocity that was given so long ago is replaced by zero."""

_REFRESH_NS, _PULSE_NS = 100_000_000, 500_000_000
_ZEROS_NS = 1_000_000_000
"""For so long zero is said again and again: a robot that missed it drives on, and the pulses would let it."""
_TOP_WHEEL_MMPS = 2540
"""The 127 steps of 20 mm/s that a wheel's byte holds."""

STOP = (command(Command.STOP), command(Command.VEL, 0), command(Command.RVEL, 0))


class Motion:
    """Packets that are due. wheels: VEL2 instead of VEL and RVEL. max_speed_mps, max_yaw_rate_radps: never more."""

    def __init__(self, wheels: bool, max_speed_mps: float, max_yaw_rate_radps: float) -> None:
        self._wheels = wheels
        self._max_speed_mps, self._max_yaw_rate_radps = max_speed_mps, max_yaw_rate_radps
        self._given: Twist2D | None = Twist2D()
        self._given_ns = self._sent_ns = -_ZEROS_NS
        self._zeros_until_ns = 0

    @property
    def commanded(self) -> Twist2D | None:
        """What the robot is to do now; None while it turns by its own control."""
        return self._given

    def drive(self, now_ns: int, twist: Twist2D, given_ns: int | None = None) -> list[bytes]:
        """The packets of a new velocity, clipped to the limits, in whole mm/s and deg/s. given_ns: when it was worked
        out, from which its age counts; by default now. One that is too old already is zero."""
        given_ns = now_ns if given_ns is None else min(given_ns, now_ns)
        if now_ns - given_ns > MAX_AGE_NS:
            twist = Twist2D()
        v_mps = max(-self._max_speed_mps, min(self._max_speed_mps, twist.v_mps))
        w_radps = max(-self._max_yaw_rate_radps, min(self._max_yaw_rate_radps, twist.w_radps))
        self._given, self._given_ns = Twist2D(v_mps, w_radps), given_ns
        self._zeros_until_ns = now_ns + MAX_AGE_NS + _ZEROS_NS
        return self._velocity(now_ns, self._given)

    def stop(self, now_ns: int) -> list[bytes]:
        """The packets of a stop with the usual braking."""
        return [STOP[0], *self.drive(now_ns, Twist2D())]

    def turn_by(self, now_ns: int, angle: float) -> list[bytes]:
        """The robot turns by its own control from now on: no velocity comes between. [rad]. Raises RefusedError."""
        return self._turn(now_ns, command(Command.DHEAD, _degrees(angle)))

    def turn_to(self, now_ns: int, heading: float) -> list[bytes]:
        """The same to a heading as the robot counts it [rad]. Raises RefusedError."""
        return self._turn(now_ns, command(Command.HEAD, _degrees(heading) % 360))

    def due(self, now_ns: int) -> list[bytes]:
        """A refresh, zero for what has grown old, or a pulse."""
        twist = self._given or Twist2D()
        if twist != Twist2D() and now_ns - self._given_ns >= MAX_AGE_NS:
            self._given = Twist2D()
            return self._velocity(now_ns, self._given)
        if now_ns < self._zeros_until_ns and now_ns - self._sent_ns >= _REFRESH_NS:
            return self._velocity(now_ns, twist)
        if now_ns - self._sent_ns >= _PULSE_NS:
            self._sent_ns = now_ns
            return [command(Command.PULSE)]
        return []

    def _turn(self, now_ns: int, packet: bytes) -> list[bytes]:
        self._given, self._zeros_until_ns, self._sent_ns = None, now_ns, now_ns
        return [packet]

    def _velocity(self, now_ns: int, twist: Twist2D) -> list[bytes]:
        self._sent_ns = now_ns
        v_mmps, w_dps = round(twist.v_mps * 1e3), round(math.degrees(twist.w_radps))
        if not self._wheels:
            return [command(Command.VEL, v_mmps), command(Command.RVEL, w_dps)]
        aside_mmps = twist.w_radps / HALF_WHEEL_BASE
        return [wheel_speeds(_within(v_mmps - aside_mmps), _within(v_mmps + aside_mmps))]


def _within(wheel_mmps: float) -> float:
    return max(-_TOP_WHEEL_MMPS, min(_TOP_WHEEL_MMPS, wheel_mmps))


def _degrees(angle: float) -> int:
    if not math.isfinite(angle):
        raise RefusedError(f"angle: expected a finite number, got {angle}")
    return round(math.degrees(angle))
