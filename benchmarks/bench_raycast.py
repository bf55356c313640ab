# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated scan of 361 beams, against every beam times every segment in numpy."""

from __future__ import annotations

import math
from typing import Callable, Dict

import numpy as np
import numpy.typing as npt
from benchmarks.timing import Row, interleaved

from edgefusion._core import raycast

Floats = npt.NDArray[np.float64]

BEAMS, ANGLE_MIN, STEP, RANGE_MAX_M = 361, -math.pi / 2, math.radians(0.5), 8.0
POSE = np.array([0.1, 0.05, 0.3])
SIDES = 16
PRODUCT, NUMPY = "product", "numpy, every beam against every segment"


def room(segments: int) -> Floats:
    """Walls 12 m apart, among them round things of 16 sides each until there are so many segments: [n, 4]."""
    random = np.random.default_rng(segments)
    outlines = [_outline(0.0, 0.0, 6 * math.sqrt(2), 4)]
    while sum(len(outline) for outline in outlines) < segments:
        x, y, radius = random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(0.03, 0.5)
        if math.hypot(x, y) > radius + 0.3:
            outlines.append(_outline(x, y, radius, SIDES))
    return np.vstack(outlines)


def _outline(x: float, y: float, radius: float, sides: int) -> Floats:
    angles = math.pi / 4 + np.arange(sides) * 2 * math.pi / sides
    corners = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


def brute_force(segments: Floats) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Ranges and rows as `raycast` gives them, for a laser that no wall touches."""
    angles = POSE[2] + (ANGLE_MIN + np.arange(BEAMS) * STEP)
    x, y = np.cos(angles)[:, None], np.sin(angles)[:, None]
    a, b = segments[:, :2] - POSE[:2], segments[:, 2:] - POSE[:2]
    left_a, left_b = x * a[:, 1] - y * a[:, 0], x * b[:, 1] - y * b[:, 0]
    along_a, along_b = x * a[:, 0] + y * a[:, 1], x * b[:, 0] + y * b[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        ranges_m = along_a + (along_b - along_a) * (left_a / (left_a - left_b))
        met = (left_a * left_b <= 0) & (ranges_m >= 0) & (ranges_m <= RANGE_MAX_M)
    ranges_m = np.where(met, ranges_m, np.inf)
    rows_met = ranges_m.argmin(axis=1)
    nearest: Floats = ranges_m[np.arange(BEAMS), rows_met]
    return nearest, np.where(np.isfinite(nearest), rows_met, -1)


def measure(segments: Floats) -> tuple[Floats, npt.NDArray[np.int32]]:
    return raycast(segments, POSE, ANGLE_MIN, STEP, BEAMS, RANGE_MAX_M)


def candidates(segments: Floats) -> Dict[str, Callable[[], object]]:
    return {PRODUCT: lambda: measure(segments), NUMPY: lambda: brute_force(segments)}


def rows(rounds: int = 21) -> list[Row]:
    """The rows of the common table."""
    table = []
    for count in (4, 1000, 2000):
        segments = room(count)
        (ours_m, our_hits), (theirs_m, their_hits) = measure(segments), brute_force(segments)
        assert np.allclose(ours_m, theirs_m, rtol=1e-12) and (our_hits == their_hits).all()
        taken = interleaved(candidates(segments), rounds)
        table.append(
            Row(
                f"raycast, {BEAMS} beams, {len(segments)} segments",
                product_s=taken[PRODUCT],
                peer=NUMPY,
                peer_s=taken[NUMPY],
                ratio=taken[NUMPY] / taken[PRODUCT],
                aim=None,
            )
        )
    return table


if __name__ == "__main__":
    for row in rows():
        print(f"{row.name}: {1e6 * row.product_s:.1f} us, {row.peer} {1e6 * row.peer_s:.1f} us, {row.ratio:.0f} times")
