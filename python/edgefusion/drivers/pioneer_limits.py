# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How fast a Pioneer may go and how it speeds up and brakes: what is configured, within what it can."""

from __future__ import annotations

import math
from dataclasses import dataclass

from edgefusion.config.navigation import BaseConfig
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_config import RobotConfig


@dataclass(frozen=True)
class Limits:
    """Of forward speed and turn rate, and of their changes."""

    speed_mps: float
    yaw_rate_radps: float
    acceleration_mps2: float
    yaw_acceleration_radps2: float

    def packets(self) -> list[bytes]:
        """What sets them, as the wire carries them: whole mm and degrees, decelerations negative."""
        acceleration = max(1, round(self.acceleration_mps2 * 1e3))
        yaw_acceleration = max(1, round(math.degrees(self.yaw_acceleration_radps2)))
        return [
            command(Command.SETV, round(self.speed_mps * 1e3)),
            command(Command.SETA, acceleration),
            command(Command.SETA, -acceleration),
            command(Command.SETRV, round(math.degrees(self.yaw_rate_radps))),
            command(Command.SETRA, yaw_acceleration),
            command(Command.SETRA, -yaw_acceleration),
        ]


def limits_of(base: BaseConfig, parameters: RobotConfig | None) -> Limits:
    """The base's, or the robot's tops where they are lower. Tops of 0 are none."""
    if parameters is None:
        return Limits(base.max_speed_mps, base.max_yaw_rate_radps, base.acceleration_mps2, base.yaw_acceleration_radps2)
    return Limits(
        min(base.max_speed_mps, _top(parameters.top_speed_mmps * 1e-3)),
        min(base.max_yaw_rate_radps, _top(math.radians(parameters.top_turn_dps))),
        min(base.acceleration_mps2, _top(parameters.top_speed_mmps2 * 1e-3)),
        min(base.yaw_acceleration_radps2, _top(math.radians(parameters.top_turn_dps2))),
    )


def _top(value: float) -> float:
    return value if value > 0 else math.inf
