# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The potential's peer: the cheapest way over the same cells, with a distance transform of OpenCV's and a Dijkstra
search of SciPy's, over eight neighbours."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from edgefusion._core import ObstacleMap
from edgefusion.types import Pose2D

Floats = npt.NDArray[np.float64]


class Cost(NamedTuple):
    """What NavigationFunction takes, and the cells' size."""

    cell_m: float
    blocked_m: float
    comfort_m: float
    weight: float


def dijkstra(cost: Cost, seen: ObstacleMap, goal: Pose2D, start: Pose2D) -> float:
    """The length of the cheapest way from the start to the goal [m], as it counts; inf where there is none."""
    costs, (column, row) = _costs(cost, seen), seen.window[:2]
    at = [
        (math.floor(pose.y_m / cost.cell_m) - row) * costs.shape[1] + math.floor(pose.x_m / cost.cell_m) - column
        for pose in (goal, start)
    ]
    return float(csgraph.dijkstra(_graph(cost, costs), indices=at[0])[at[1]])


def _costs(cost: Cost, seen: ObstacleMap) -> Floats:
    """What a metre costs in each cell; inf where the base's middle cannot be."""
    column, row, columns, rows = seen.window
    free = np.ones((rows, columns), np.uint8)
    x, y = np.floor(seen.points() / cost.cell_m).astype(int).T
    free[y - row, x - column] = 0
    apart_m = cv2.distanceTransform(free, cv2.DIST_L2, 5).astype(float) * cost.cell_m
    near = np.clip((cost.comfort_m - apart_m) / (cost.comfort_m - cost.blocked_m), 0, None)
    return np.where(apart_m < cost.blocked_m, np.inf, 1 + cost.weight * near**2)


def _graph(cost: Cost, costs: Floats) -> Any:
    """Every cell with its eight neighbours, as a sparse matrix of what a step costs."""
    number = np.arange(costs.size).reshape(costs.shape)
    parts = []
    for a, b, length in (
        (np.s_[:, :-1], np.s_[:, 1:], 1.0),
        (np.s_[:-1], np.s_[1:], 1.0),
        (np.s_[:-1, :-1], np.s_[1:, 1:], math.sqrt(2)),
        (np.s_[:-1, 1:], np.s_[1:, :-1], math.sqrt(2)),
    ):
        step_m = cost.cell_m * length * (costs[a] + costs[b]) / 2
        kept = np.isfinite(step_m)
        parts.append((step_m[kept], number[a][kept], number[b][kept]))
    values, here, there = (np.concatenate(each) for each in zip(*parts))
    both = (np.concatenate([here, there]), np.concatenate([there, here]))
    return sparse.coo_matrix((np.tile(values, 2), both), shape=(costs.size, costs.size)).tocsr()
