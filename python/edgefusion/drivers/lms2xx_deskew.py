# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Undoes the robot's way during a scan: the ranges become those that a scan of one instant would have."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from edgefusion.pose_history import PoseHistory
from edgefusion.types import Scan

Floats = npt.NDArray[np.float64]

# Neighbours that differ by no more than this and this share are one surface, between whose points one may interpolate.
_STEP_M, _STEP_SHARE = 0.1, 0.05
_GAP = 1.5
"""A direction farther than so many increments from any beam is unknown."""


def deskewed(scan: Scan, history: PoseHistory, T_base_laser: Floats) -> Scan:
    """The scan as if all beams had been measured at its stamp, in the same directions; beam_dt_ns is None.

    history: the robot's poses, which must cover the whole sweep. T_base_laser [4, 4]: laser coordinates into those of
    base_link; level, also upside down. Directions that no beam looked into become NaN. Raises RefusedError where the
    poses do not cover the sweep.
    """
    if scan.beam_dt_ns is None or not len(scan.ranges_m):
        return replace(scan, beam_dt_ns=None)
    angles, ranges_m = _seen_from_the_stamp(scan, history, T_base_laser)
    return replace(scan, ranges_m=_on_grid(scan, angles, ranges_m), beam_dt_ns=None)


def _seen_from_the_stamp(scan: Scan, history: PoseHistory, T_base_laser: Floats) -> tuple[Floats, Floats]:
    """Direction and range of what every beam met, from where the laser was at the stamp.

    Of a beam that met nothing, or nobody knows what, only the direction changes.
    """
    x, y, theta = _motion(scan, history)
    A, t = T_base_laser[:2, :2], T_base_laser[:2, 3]
    finite = np.isfinite(scan.ranges_m)
    reach, here = np.where(finite, scan.ranges_m, 1.0), np.where(finite, 1.0, 0.0)
    beams = A @ (reach * np.stack([np.cos(scan.angles), np.sin(scan.angles)])) + here * t[:, None]
    c, s = np.cos(theta), np.sin(theta)
    moved = np.stack([c * beams[0] - s * beams[1] + here * x, s * beams[0] + c * beams[1] + here * y])
    seen = np.linalg.inv(A) @ (moved - here * t[:, None])
    ranges_m = np.where(finite, np.hypot(seen[0], seen[1]), scan.ranges_m)
    return np.arctan2(seen[1], seen[0]), ranges_m


def _motion(scan: Scan, history: PoseHistory) -> Floats:
    """The robot's pose (x, y, theta) [3, n] at every beam's time, in base_link at the stamp."""
    assert scan.beam_dt_ns is not None
    dt_ns = scan.beam_dt_ns
    at = history.at(scan.stamp_ns)
    first_ns, last_ns = min(int(dt_ns.min()), 0), max(int(dt_ns.max()), 0)
    # Before and after the stamp the robot moves evenly: a sweep is shorter than the odometry's cycle.
    knots = [history.at(scan.stamp_ns + ns).relative_to(at) for ns in (first_ns, 0, last_ns)]
    values = np.array([[pose.x_m, pose.y_m, pose.theta] for pose in knots])
    return np.array([np.interp(dt_ns, [first_ns, 0, last_ns], column) for column in values.T])


def _on_grid(scan: Scan, angles: Floats, ranges_m: Floats) -> npt.NDArray[np.float32]:
    """Ranges in the scan's own directions: between two points of a surface as on a straight wall, else the nearest."""
    step = scan.angle_increment
    middle = scan.angle_min + step * (len(ranges_m) - 1) / 2
    # Counted in increments from the middle one, so that no direction lies across the break at half a turn.
    places = np.remainder(angles - middle + math.pi, 2 * math.pi) - math.pi
    places = places / step + (len(ranges_m) - 1) / 2
    order = np.argsort(places, kind="stable")
    places, ranges_m = places[order], ranges_m[order]
    grid = np.arange(len(ranges_m), dtype=float)
    after = np.clip(np.searchsorted(places, grid), 1, max(len(places) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(places) - 1)
    gap = places[after] - places[before]
    share = np.clip((grid - places[before]) / np.where(gap > 0, gap, 1.0), 0.0, 1.0)
    a, b = ranges_m[before], ranges_m[after]
    result = np.where(share < 0.5, a, b)
    wall = np.flatnonzero(_one_surface(a, b))
    result[wall] = 1 / ((1 - share[wall]) / a[wall] + share[wall] / b[wall])
    away = np.minimum(np.abs(grid - places[before]), np.abs(places[after] - grid))
    result[away > _GAP] = np.nan
    return result.astype(np.float32)


def _one_surface(a: Floats, b: Floats) -> npt.NDArray[np.bool_]:
    both = np.isfinite(a) & np.isfinite(b) & (np.minimum(a, b) > 0)
    near, far = np.where(both, np.minimum(a, b), 1.0), np.where(both, np.maximum(a, b), 1.0)
    return np.asarray(both & (far - near <= _STEP_M + _STEP_SHARE * near))
