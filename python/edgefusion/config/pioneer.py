# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of a Pioneer: its line, what its counts are in metres, and when its battery is low."""

from __future__ import annotations

import sys
from typing import Literal, Optional, Tuple

import msgspec

from edgefusion.config.strict import Place, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Baudrate = Literal[9600, 19200, 38400, 57600, 115200]
Factor = Annotated[float, msgspec.Meta(gt=0, le=100)]
Volts = Annotated[float, msgspec.Meta(ge=0, le=60)]


class PioneerConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A Pioneer, and how it is spoken to. How fast it may go is the base's."""

    port: Place = "/dev/robot"
    """A serial port, or socket://HOST:PORT. docs/wiring.md says how it gets a name that stays."""
    baudrates: Annotated[Tuple[Baudrate, ...], msgspec.Meta(min_length=1, max_length=5)] = (
        9600,
        38400,
        19200,
        115200,
        57600,
    )
    """Tried in this order until the robot answers; after power-on it listens at 9600. [baud]"""
    faster_baudrate: Optional[Baudrate] = 38400
    """Switched to once connected, if the robot says that it comes back by itself at the end, and it is faster than the
    one it was found at. [baud]"""
    distance_factor_mm: Optional[Factor] = None
    """What a count of its position is, where a calibrated robot differs from its kind."""
    heading_factor: Optional[Annotated[float, msgspec.Meta(gt=0, le=0.01)]] = None
    """What a count of its heading is, where a calibrated robot differs from its kind. [rad]"""
    speed_factor_mmps: Optional[Factor] = None
    """What a count of its wheels' speed is, where a calibrated robot differs from its kind."""
    range_factor_mm: Optional[Factor] = None
    """What a count of its sonar is, where a calibrated robot differs from its kind."""
    velocities: Literal["base", "wheels"] = "base"
    """VEL and RVEL in mm/s and deg/s ("base"), or VEL2 in steps of 20 mm/s a wheel ("wheels")."""
    sonar: bool = True
    """Whether the sonar is switched on at the start: what is behind is seen by nothing else."""
    enable_motors: bool = True
    """Whether the motors are enabled at the start; else by the button on the robot."""
    low_battery_v: Volts = 11.5
    """Below this it takes no new goals; below it for 5 s it says that it is to be charged."""
    empty_battery_v: Volts = 11.0
    """Below this for 5 s it stops, wherever it is."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.low_battery_v <= self.empty_battery_v:
            raise RefusedError(
                f"low_battery_v: expected more than empty_battery_v, {self.empty_battery_v:g}, "
                f"got {self.low_battery_v:g}"
            )
