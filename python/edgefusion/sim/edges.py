# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where a scan jumps from one surface to another, and does not merely follow a slanted wall or go round a corner."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from edgefusion._core import raycast

Floats = npt.NDArray[np.float64]

STEPS_BETWEEN = 16
"""Into how many steps the way from one beam to the next is cut to see whether it is a jump."""


class ExactScan(NamedTuple):
    """What every beam truly meets, in the world: origins [n, 2] [m], angles [n], ranges_m [n], rows int32[n] or -1."""

    origins: Floats
    angles: Floats
    ranges_m: Floats
    hits: npt.NDArray[np.int32]


def edges(scan: ExactScan, segments: Floats, edge_m: float) -> npt.NDArray[np.intp]:
    """Every beam i between which and beam i + 1 the range jumps by more than edge_m; both meet something.

    A continuous surface steps less from beam to beam the nearer the beams are together, so those that step far are
    looked at more closely.
    """
    with np.errstate(invalid="ignore"):  # inf - inf
        far = np.abs(np.diff(scan.ranges_m)) > edge_m
    meets = scan.hits >= 0
    candidates = np.flatnonzero(far & meets[:-1] & meets[1:] & (np.diff(scan.hits) != 0)).tolist()
    return np.array([i for i in candidates if _jumps(scan, i, segments, edge_m)], np.intp)


def _jumps(scan: ExactScan, i: int, segments: Floats, edge_m: float) -> bool:
    """Whether the range still jumps between beam i and the next one when beams are cast in between."""
    step = (scan.angles[i + 1] - scan.angles[i]) / STEPS_BETWEEN
    if step == 0:  # the robot turns as fast as the mirror: the same direction, a little later
        return True
    pose = [*scan.origins[i], scan.angles[i]]
    reach_m = 2 * float(scan.ranges_m[i : i + 2].max())
    between = raycast(segments, pose, 0.0, step, STEPS_BETWEEN + 1, reach_m)[0]
    with np.errstate(invalid="ignore"):
        return bool((np.abs(np.diff(between)) > edge_m).any())
