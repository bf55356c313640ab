# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated Pioneer says of itself while a session is open: its SIPs, and what streams beside them."""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE
from edgefusion.sim import sip_robot_packets as packets
from edgefusion.sim.body import Body
from edgefusion.sim.sip_robot_character import Character
from edgefusion.sim.sip_robot_sonars import SonarTurns
from edgefusion.sim.sip_robot_wheels import WheelTicks

ENCODER, IOREQUEST = 19, 40
_FULL_DV = 130
_TURN_COUNTS = 4096


class Reports:
    """battery_dv, digital_in, digital_out: as they are reported. origin: where its counts are 0."""

    def __init__(self, body: Body, character: Character, now_ns: int) -> None:
        self._body, self._character = body, character
        self.battery_dv, self.digital_in, self.digital_out = _FULL_DV, 0, 0
        self.reset(now_ns)

    def reset(self, now_ns: int) -> None:
        """As after power-on: nothing streams, and all counts are 0."""
        self.origin = self._body.odometry
        self.sonars = SonarTurns(self._character.sonars, now_ns)
        self.wheels = WheelTicks(self._character.ticks_per_mm, self.origin)
        self._streams: Dict[int, bool] = {}

    def set_origin(self) -> None:
        """Here, and in this direction, its counts are 0 from now on."""
        self.origin = self._body.odometry

    def set_outputs(self, mask: int, values: int) -> None:
        """Those of the digital lines that are in the mask."""
        self.digital_out = self.digital_out & ~mask | values & mask

    def stream(self, number: int, value: int) -> bytes:
        """0: no longer, 1: once, 2: with every SIP. Returns what is to be said at once."""
        self._streams[number] = value == 2
        return self._extra(number) if value == 1 else b""

    def end(self) -> None:
        """Of the session."""
        self._streams.clear()

    def due(self, now_ns: int, motors: bool, e_stop: bool, stalled: Tuple[bool, bool]) -> bytes:
        """A SIP and what streams with it."""
        twist = self._body.twist
        aside_mmps = twist.w_radps / HALF_WHEEL_BASE
        status = packets.status(
            self._counts(),
            (round(twist.v_mps * 1e3 - aside_mmps), round(twist.v_mps * 1e3 + aside_mmps)),
            round(math.degrees(twist.w_radps) * 10),
            self.battery_dv,
            stalled,
            self.bumpers(),
            motors,
            e_stop,
            self.sonars.on,
            self._heard(now_ns),
            (self.digital_in, self.digital_out),
        )
        return status + b"".join(self._extra(number) for number, streams in self._streams.items() if streams)

    def bumpers(self) -> Tuple[int, int]:
        """Front and rear, bit 0 the first."""
        front, rear = (sum(pressed << i for i, pressed in enumerate(side)) for side in self._body.bumpers)
        return front, rear

    def _extra(self, number: int) -> bytes:
        if number == IOREQUEST:
            return packets.io((self.digital_in, self.digital_out), self.bumpers())
        return packets.encoders(*self.wheels.ticks)

    def _counts(self) -> Tuple[int, int, int]:
        pose, mask = self._body.odometry.relative_to(self.origin), (1 << self._character.counter_bits) - 1
        x, y = (round(metres * 1e3 / self._character.distance_mm) & mask for metres in (pose.x_m, pose.y_m))
        half = _TURN_COUNTS // 2
        heading = (round(pose.theta * _TURN_COUNTS / (2 * math.pi)) + half) % _TURN_COUNTS - half
        return x, y, heading

    def _heard(self, now_ns: int) -> List[Tuple[int, int]]:
        return [(number, _range_mm(self._body.sonar_m(number))) for number in self.sonars.fired(now_ns)]


def _range_mm(range_m: float) -> int:
    return packets.NOTHING_COUNTS if range_m * 1e3 >= packets.NOTHING_COUNTS else round(range_m * 1e3)
