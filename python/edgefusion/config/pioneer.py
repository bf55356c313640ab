# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of a Pioneer: its line, what its counts are in metres, and when its battery is low."""

from __future__ import annotations

import sys
from typing import Literal, Optional, Tuple

import msgspec

from edgefusion.config.strict import check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Baudrate = Literal[9600, 19200, 38400, 57600, 115200]
Factor = Annotated[float, msgspec.Meta(gt=0, le=100)]
Volts = Annotated[float, msgspec.Meta(ge=0, le=60)]


class PioneerConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How a Pioneer is spoken to. How fast it may go is the base's."""

    # Tried in this order until the robot answers; after power-on it listens at 9600.
    baudrates: Annotated[Tuple[Baudrate, ...], msgspec.Meta(min_length=1, max_length=5)] = (
        9600,
        38400,
        19200,
        115200,
        57600,
    )
    # Switched to once connected, if the robot says that it comes back by itself at the end; none: stays as found.
    faster_baudrate: Optional[Baudrate] = 38400
    # What a count is, where a calibrated robot differs from its kind: [mm], [rad], [mm/s], [mm].
    distance_factor_mm: Optional[Factor] = None
    heading_factor: Optional[Annotated[float, msgspec.Meta(gt=0, le=0.01)]] = None
    speed_factor_mmps: Optional[Factor] = None
    range_factor_mm: Optional[Factor] = None
    # "wheels" sends VEL2, in steps of 20 mm/s a wheel; "base" VEL and RVEL, in mm/s and deg/s.
    velocities: Literal["base", "wheels"] = "base"
    sonar: bool = True
    # Whether the motors are enabled at the start; else by the button on the robot.
    enable_motors: bool = True
    # Below the first it is to be charged, and says so; below the second it takes no goals and stops.
    low_battery_v: Volts = 11.5
    empty_battery_v: Volts = 11.0

    def __post_init__(self) -> None:
        check_fields(self)
        if self.low_battery_v <= self.empty_battery_v:
            raise RefusedError(
                f"low_battery_v: expected more than empty_battery_v, {self.empty_battery_v:g}, "
                f"got {self.low_battery_v:g}"
            )
