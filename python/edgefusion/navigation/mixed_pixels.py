# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Beams that lie on two surfaces read something between: where nothing is. They are unknown."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

EDGE_M = 0.06
"""A beam that is so much farther than one neighbour, and so much nearer than the other, lies between two surfaces, or
on one that is looked along: that is straight. A beam nearer than both its neighbours is an obstacle."""

STRAIGHT_M = 0.06
"""How far a beam may be off the straight line through its neighbours' ends."""


def without_mixed(ranges_m: npt.NDArray[np.float32], bearings: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """The same ranges [n], NaN where a beam lies on two surfaces. bearings [n]: of the beams, in any order."""
    order = np.argsort(bearings, kind="stable")
    order = order[~np.isnan(ranges_m[order])]
    cleaned = ranges_m.copy()
    cleaned[order[_is_mixed(ranges_m[order])]] = np.nan
    return cleaned


def _is_mixed(ranges_m: npt.NDArray[np.float32]) -> npt.NDArray[np.bool_]:
    """Of neighbouring beams that measured something."""
    mixed = np.zeros(len(ranges_m), bool)
    if len(ranges_m) < 3:
        return mixed
    before, here, after = ranges_m[:-2], ranges_m[1:-1], ranges_m[2:]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # infinities, ranges of next to 0
        rising = (here - before > EDGE_M) & (after - here > EDGE_M)
        falling = (before - here > EDGE_M) & (here - after > EDGE_M)
        # On a straight surface 1 / range is linear in the angle, as far as two steps.
        straight = np.abs(here - 2 / (1 / before + 1 / after)) < STRAIGHT_M
    continued = np.zeros_like(straight)
    continued[1:] |= straight[:-1]
    continued[:-1] |= straight[1:]
    mixed[1:-1] = (rising | falling) & np.isfinite(here) & ~(straight & continued)
    return mixed
