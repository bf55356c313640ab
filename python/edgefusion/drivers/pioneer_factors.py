# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a Pioneer's counts are in metres and radians: it depends on its board, which its subtype names."""

from __future__ import annotations

import math
from dataclasses import dataclass

from edgefusion.config.pioneer import PioneerConfig
from edgefusion.errors import RefusedError

HEADING = 2 * math.pi / 4096
"""A turn has 4096 counts on every board."""

HALF_WHEEL_BASE = 0.0056
"""ARIA's DiffConvFactor: half the difference of the wheels' speeds [mm/s], times this, is the turn rate [rad/s]."""

_DISTANCE_MM = {"p3dx": 0.485, "p3dx-sh": 1.0}
"""The old H8 board counts in 0.485 mm, the SH2 board in millimetres."""


@dataclass(frozen=True)
class Factors:
    """distance_m, range_m: of a count; heading: of a count [rad]; speed_mps: of a count."""

    distance_m: float
    heading: float
    speed_mps: float
    range_m: float


def factors_for(subtype: str, config: PioneerConfig) -> Factors:
    """Those of a subtype as the robot writes it, unless the configuration says otherwise.

    Raises RefusedError for a subtype that is not known, where the configuration does not help either: a wrong factor
    is an error of 2.06.
    """
    distance_mm = config.distance_factor_mm or _DISTANCE_MM.get(subtype.lower())
    if distance_mm is None:
        known = " or ".join(_DISTANCE_MM)
        raise RefusedError(f"robot: expected a subtype of {known}, or distance_factor_mm in [robot], got {subtype!r}")
    return Factors(
        distance_mm * 1e-3,
        config.heading_factor or HEADING,
        (config.speed_factor_mmps or 1.0) * 1e-3,
        (config.range_factor_mm or 1.0) * 1e-3,
    )
