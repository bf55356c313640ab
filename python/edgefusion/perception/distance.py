# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How far away a cluster's nearest surface is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion._core import nearest_range
from edgefusion.config import PerceptionConfig
from edgefusion.types import Cluster, Scan


@dataclass(frozen=True)
class Surface:
    """The nearest surface of a cluster, in the laser's frame at the scan's stamp."""

    range_m: float
    sigma_m: float
    bearing: float

    def point(self) -> npt.NDArray[np.float64]:
        """[x, y, z] in the laser's frame [m]."""
        return self.range_m * np.array([np.cos(self.bearing), np.sin(self.bearing), 0.0])


def nearest_surface(scan: Scan, cluster: Cluster, config: PerceptionConfig) -> Surface:
    """The nearest range corrected for the noise of the beams, or the paper's min(r)."""
    ranges_m = scan.ranges_m[cluster.indices]
    if config.distance == "minimum":
        beam = int(ranges_m.argmin())
        range_m, sigma_m = float(ranges_m[beam]), config.range_sigma_m
    else:
        range_m, sigma_m, beam = nearest_range(ranges_m, config.range_sigma_m)
    return Surface(range_m, sigma_m, float(scan.angle_min + scan.angle_increment * cluster.indices[beam]))
