# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The sonar ring of a Pioneer 3-DX: where what it hears is."""

from __future__ import annotations

import math
from typing import Dict, NamedTuple

import numpy as np
import numpy.typing as npt

from edgefusion.drivers.pioneer_state import RobotState

KEPT_NS = 1_000_000_000
"""A ring of sixteen takes 640 ms to fire once."""


class SonarPlace(NamedTuple):
    """In base_link [m, rad]."""

    x_m: float
    y_m: float
    theta: float


def _place(x_mm: int, y_mm: int, degrees: int) -> SonarPlace:
    return SonarPlace(x_mm * 1e-3, y_mm * 1e-3, math.radians(degrees))


_FRONT = ((69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10))
_REAR = ((-157, -136, -90), (-203, -119, -130), (-237, -78, -150), (-255, -27, -170))
RING = tuple(
    _place(x, side * y, side * degrees)
    for places, sides in ((_FRONT, (1, -1)), (_REAR, (1, -1)))
    for side in sides
    for x, y, degrees in (places if side > 0 else places[::-1])
)
"""Sonars 0 to 7 from the left over the front to the right, 8 to 15 from the right over the back to the left."""

_REAR_NUMBERS = range(8, 16)


class SonarRing:
    """Keeps each sonar's newest range for a second: a SIP names only those that fired since the last."""

    def __init__(self) -> None:
        self._heard: Dict[int, tuple[int, float]] = {}

    def add(self, state: RobotState) -> None:
        """What this state's sonars heard."""
        for number, range_m in state.sonar_m.items():
            self._heard[number] = state.stamp_ns, range_m

    def ranges_m(self, stamp_ns: int) -> Dict[int, float]:
        """By number; inf: no echo. Those that have not fired for a second are not among them."""
        return {number: m for number, (then_ns, m) in self._heard.items() if stamp_ns - then_ns <= KEPT_NS}

    def rear_points_m(self, stamp_ns: int) -> npt.NDArray[np.float64]:
        """What is behind, float64[k, 2] in base_link: on each rear sonar's axis, though an echo may come from 15
        degrees beside it."""
        ranges_m = self.ranges_m(stamp_ns)
        points = [_ahead(RING[n], ranges_m[n]) for n in _REAR_NUMBERS if math.isfinite(ranges_m.get(n, math.inf))]
        return np.array(points, float).reshape(-1, 2)


def _ahead(place: SonarPlace, range_m: float) -> tuple[float, float]:
    return place.x_m + range_m * math.cos(place.theta), place.y_m + range_m * math.sin(place.theta)
