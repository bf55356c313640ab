# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the base that is driven, and of how it is driven to a goal."""

from __future__ import annotations

import math
import sys
from typing import Literal, Tuple

import msgspec

from edgefusion.config.outline import check_outline
from edgefusion.config.strict import Seconds, UpTo1, UpTo10, UpTo100, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Coordinate = Annotated[float, msgspec.Meta(ge=-10, le=10)]
Point = Tuple[Coordinate, Coordinate]
Delay = Annotated[float, msgspec.Meta(ge=0, le=1)]

P3DX_FOOTPRINT_M = ((0.210, 0.2125), (-0.301, 0.2125), (-0.301, -0.2125), (0.210, -0.2125))
"""A Pioneer 3-DX about the middle of its wheel axle: the tail is longer than the nose, and swings."""


class BaseConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The base: its hull, where the laser is on it, how fast it may go. The defaults are a Pioneer 3-DX's."""

    footprint_m: Annotated[Tuple[Point, ...], msgspec.Meta(min_length=3, max_length=32)] = P3DX_FOOTPRINT_M
    """Corners of the hull, seen from above, in base_link, whose origin is the middle of the axle; convex."""
    laser_pose: Tuple[Coordinate, Coordinate, Coordinate] = (0.10, 0.0, 0.0)
    """The laser's x, y and direction in base_link. [m, m, rad]"""
    max_speed_mps: UpTo10 = 0.5
    """It is never driven faster, forwards or backwards."""
    max_yaw_rate_radps: UpTo10 = math.radians(60)
    """It never turns faster."""
    acceleration_mps2: UpTo10 = 0.3
    """What the drive does, not what it should, accelerating and braking."""
    yaw_acceleration_radps2: UpTo100 = math.radians(100)
    """The same of its turning."""
    command_delay_s: Delay = 0.05
    """From a command's computation until the wheels begin to follow it."""

    def __post_init__(self) -> None:
        check_fields(self)
        check_outline("footprint_m", self.footprint_m)


class KhatibConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The paper's potential field: attraction of the goal, repulsion of what is near."""

    attraction: UpTo100 = 1.0
    """How strongly the goal attracts. [weight]"""
    repulsion: UpTo100 = 0.05
    """How strongly what is near repels. [weight]"""
    threshold_m: UpTo10 = 1.0
    """Obstacles farther than this do not repel, and the P-controller with the higher gain drives; it hands over to the
    field below this distance."""
    hysteresis_m: UpTo1 = 0.2
    """The P-controller takes over again above threshold_m and this."""
    near_gain: UpTo10 = 0.6
    """k of eq. (4), with the field. [1/s]"""
    far_gain: UpTo10 = 1.2
    """k of eq. (4), with the P-controller. [1/s]"""


class NavigationConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the base is driven to a goal."""

    field: Literal["navigation-function", "khatib"] = "navigation-function"
    """The one that never sticks, or the paper's."""
    khatib: KhatibConfig = KhatibConfig()
    cell_m: Annotated[float, msgspec.Meta(ge=0.02, le=0.2)] = 0.05
    """Side of a cell of the map of what was seen."""
    margin_m: Annotated[float, msgspec.Meta(ge=0, le=0.5)] = 0.025
    """Kept between the hull and what the laser saw; manoeuvres keep half of it."""
    comfort_m: UpTo10 = 0.5
    """Ways that come nearer to obstacles than this, beyond the hull's inscribed circle, are longer than they are."""
    comfort_weight: UpTo100 = 6.0
    """Right beside an obstacle a metre counts as 1 + so many. [weight]"""
    max_scan_age_s: Seconds = 0.75
    """Scans older than this are not driven by."""
    patience_s: Seconds = 30.0
    """Without coming nearer to the goal for so long, it counts as out of reach."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.comfort_m <= self.margin_m:
            raise RefusedError(f"comfort_m: expected more than margin_m, {self.margin_m:g}, got {self.comfort_m:g}")
