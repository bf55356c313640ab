# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What navigation's tests put on a map, and the exact geometry that they compare with."""

from __future__ import annotations

import numpy as np

from edgefusion._core import Footprint, NavigationFunction, ObstacleMap

P3DX = np.array([[0.210, 0.2125], [-0.301, 0.2125], [-0.301, -0.2125], [0.210, -0.2125]])
NONE = np.zeros((0, 4))


def insert(map_, ranges_m, pose=(0.0, 0.0, 0.0), angle_min=0.0, step=0.01, range_min_m=0.0, range_max_m=20.0, at_s=0.0):
    """One scan, all of whose beams are measured from one pose."""
    poses = np.tile(np.asarray(pose, float), (len(ranges_m), 1))
    ranges = np.asarray(ranges_m, np.float32)
    map_.insert(poses, ranges, angle_min, step, range_min_m, range_max_m, round(at_s * 1e9))


def put(map_, points_m):
    """Points, each seen by a laser so near that its beam comes through nothing."""
    points = np.asarray(points_m, float).reshape(-1, 2)
    poses = np.hstack([points - (0.0625, 0.0), np.zeros((len(points), 1))])
    map_.insert(poses, np.full(len(points), 0.0625, np.float32), 0.0, 1e-12, 0.0, 20.0, 0)


def see(map_, x=0.0, y=0.0, radius_m=3.0):
    """Makes the ground around known, and free of what is there."""
    beams = 2000
    insert(map_, np.full(beams, np.inf), (x, y, 0.0), 0.0, 2 * np.pi / beams, range_max_m=radius_m)


def wall(a, b, spacing_m=0.02):
    n = max(2, round(np.hypot(*np.subtract(b, a)) / spacing_m) + 1)
    return np.linspace(a, b, n)


def box(x0, y0, x1, y1):
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return np.concatenate([wall(corners[i - 1], corners[i]) for i in range(4)])


def map_with(points_m, cell_m=0.05, base=(0.0, 0.0), target=(0.0, 0.0), seen_m=0.0):
    map_ = ObstacleMap(cell_m)
    map_.cover(*base, *target)
    if seen_m:
        see(map_, *base, seen_m)
    for _ in range(2):  # what was seen once shuts no way
        put(map_, points_m)
    return map_


def computed(map_, goal, base=(0.0, 0.0), blocked_m=0.2, comfort_m=0.7, weight=4.0, tolerance_m=0.05):
    function = NavigationFunction(blocked_m, comfort_m, weight)
    function.begin(map_, *goal, tolerance_m, *base)
    assert function.advance(map_, 10**9)
    return function


def lines_gap(corners, poses, points):
    """The largest distance from a line through an edge, of every pose [n, 3] and point [k, 2]: [n, k]; points [n, k, 2]
    are others for every pose."""
    local = _in_base(poses, points)
    a, b = corners, np.roll(corners, -1, axis=0)
    x, y = corners.T
    if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) < 0:
        a, b = b, a
    along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    return (local @ normal.T - np.sum(normal * a, axis=1)).max(axis=-1)


def distance(corners, poses, points):
    """The true one, below 0 inside."""
    local = _in_base(poses, points)[..., None, :]
    a, b = corners, np.roll(corners, -1, axis=0)
    edge = b - a
    share = np.clip(np.sum((local - a) * edge, axis=-1) / np.sum(edge * edge, axis=-1), 0, 1)
    apart = np.linalg.norm(local - a - share[..., None] * edge, axis=-1).min(axis=-1)
    return np.where(lines_gap(corners, poses, points) < 0, -apart, apart)


def _in_base(poses, points):
    poses, points = np.asarray(poses, float).reshape(-1, 3), np.asarray(points, float)
    off = np.atleast_3d(points).reshape((-1, *points.shape[-2:])) - poses[:, None, :2]
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    return np.stack([c * off[..., 0] + s * off[..., 1], c * off[..., 1] - s * off[..., 0]], axis=-1)


def p3dx():
    return Footprint(P3DX)
