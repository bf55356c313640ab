# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a simulated Pioneer's firmware moves its body: velocities, headings, distances, and its watchdog."""

from __future__ import annotations

import math

from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE
from edgefusion.sim.body import Body
from edgefusion.sim.sip_robot_ramp import Ramp
from edgefusion.types import Pose2D, Twist2D

_TURN_GAIN, _TURNED, _TURN_BRAKE_RADPS2 = 2.0, math.radians(0.5), math.radians(60)
_MOVE_GAIN, _MOVED_M, _MOVE_BRAKE_MPS2 = 2.0, 0.003, 0.15


class Drive:
    """What it was told last, and what becomes of that. Nothing moves while the motors are off.

    When nothing is heard for too long it stops; when something is heard again it goes on with what it was told last,
    as the firmware of a real one does. speed, turn: their limits; the body may be slower.
    """

    def __init__(self, body: Body, speed: Ramp, turn: Ramp, now_ns: int) -> None:
        self._body, self._now_ns = body, now_ns
        self.speed, self.turn = speed, turn
        self.motors = self.starving = False
        self._v_mps = self._w_radps = 0.0
        self._heading: float | None = None
        self._move: tuple[Pose2D, float] | None = None

    def set_speed(self, v_mps: float) -> None:
        """Forward, until told otherwise."""
        self._v_mps, self._move = v_mps, None

    def set_turn(self, w_radps: float) -> None:
        """Left, until told otherwise."""
        self._w_radps, self._heading = w_radps, None

    def set_wheels(self, left_mps: float, right_mps: float) -> None:
        """The same, by wheels."""
        self.set_speed((left_mps + right_mps) / 2)
        self.set_turn((right_mps - left_mps) * 1e3 / 2 * HALF_WHEEL_BASE)

    def turn_to(self, heading: float) -> None:
        """A heading of the body's odometry."""
        self._w_radps, self._heading = 0.0, heading

    def turn_by(self, angle: float) -> None:
        """From where it is."""
        self.turn_to(self._body.odometry.theta + angle)

    def turn_on_by(self, angle: float) -> None:
        """From where it was told to turn to."""
        self.turn_to((self._body.odometry.theta if self._heading is None else self._heading) + angle)

    def move(self, way_m: float) -> None:
        """Straight on, or back."""
        self._v_mps, self._move = 0.0, (self._body.odometry, way_m)

    def stop(self) -> None:
        """With the usual ramp."""
        self.set_speed(0.0)
        self.set_turn(0.0)

    def halt(self) -> None:
        """Without one."""
        self.stop()
        self.speed.halt()
        self.turn.halt()
        self._body.halt()

    def run(self, now_ns: int) -> None:
        """Passes on what it was told, as of now."""
        dt_s, self._now_ns = max(0, now_ns - self._now_ns) / 1e9, max(now_ns, self._now_ns)
        still = not self.motors or self.starving
        v_mps = self.speed.towards(0.0 if still else self._speed(), dt_s)
        w_radps = self.turn.towards(0.0 if still else self._turn(), dt_s)
        self._body.command(Twist2D(v_mps, w_radps))

    def _speed(self) -> float:
        if self._move is None:
            return self._v_mps
        begin, way_m = self._move
        left_m = way_m - self._body.odometry.relative_to(begin).x_m
        if abs(left_m) < _MOVED_M:
            self._move = None
            return 0.0
        return _approach(left_m, _MOVE_GAIN, _MOVE_BRAKE_MPS2)

    def _turn(self) -> float:
        if self._heading is None:
            return self._w_radps
        left = math.remainder(self._heading - self._body.odometry.theta, 2 * math.pi)
        return 0.0 if abs(left) < _TURNED else _approach(left, _TURN_GAIN, _TURN_BRAKE_RADPS2)


def _approach(left: float, gain: float, brake: float) -> float:
    """The speed from which it can still come to rest where it is to."""
    return math.copysign(min(gain * abs(left), math.sqrt(2 * brake * abs(left))), left)
