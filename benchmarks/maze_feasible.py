# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a hull can get from one pose to another at all, by search over x, y and direction; no navigator is asked.

Free poses are connected where the hull can move or turn from one to the next without touching. A differential drive
can follow every such connection, however closely, by driving to and fro.
"""

from __future__ import annotations

import math
from typing import List, Sequence, Set, Tuple

import cv2
import numpy as np
import numpy.typing as npt
from benchmarks.maze_shapes import Floats

from edgefusion.sim.hull import Hull
from edgefusion.types import Pose2D

CELL_M = 0.02
DIRECTIONS = 60
_SHIFT = 4
"""cv2 takes corners in fractions of a cell: this many bits of them."""

Labels = npt.NDArray[np.int32]


def reachable(segments: Floats, hull: Hull, start: Pose2D, goal: Pose2D) -> bool:
    """Whether the goal is connected with the start. Cells that a segment's border touches count as taken, so gaps that
    are only CELL_M wider than the hull may count as closed, never the other way round."""
    ends = segments.reshape(-1, 2)
    origin = ends.min(axis=0)
    columns, rows = np.ceil((ends.max(axis=0) - origin) / CELL_M).astype(int) + 1
    layers = [_components(segments, hull, k, origin, (rows, columns)) for k in range(DIRECTIONS)]
    first, last = (_node(pose, layers, origin) for pose in (start, goal))
    return first[1] != 0 and last[1] != 0 and last in _connected(first, layers)


def _components(segments: Floats, hull: Hull, direction: int, origin: Floats, shape: Tuple[int, int]) -> Labels:
    """Connected free places of the axle in one direction, from 1; 0 where the hull would touch: [rows, columns]."""
    corners = hull.at(Pose2D(0.0, 0.0, 2 * math.pi / DIRECTIONS * direction))
    free = np.ones(shape, np.uint8)
    for a_x, a_y, b_x, b_y in segments:
        # The axle is where the hull touches the segment when it is on the segment less the hull.
        taken = np.vstack([(a_x, a_y) - corners, (b_x, b_y) - corners])
        cells = np.rint((taken - origin) / CELL_M * 2**_SHIFT).astype(np.int32)
        cv2.fillConvexPoly(free, cv2.convexHull(cells), 0, shift=_SHIFT)
    return np.asarray(cv2.connectedComponents(free, connectivity=4)[1], np.int32)


def _node(pose: Pose2D, layers: Sequence[Labels], origin: Floats) -> Tuple[int, int]:
    """(direction, component) of a pose."""
    direction = round(pose.theta / (2 * math.pi) * DIRECTIONS) % DIRECTIONS
    column, row = np.rint((np.array([pose.x_m, pose.y_m]) - origin) / CELL_M).astype(int)
    rows, columns = layers[direction].shape
    inside = 0 <= row < rows and 0 <= column < columns
    return direction, int(layers[direction][row, column]) if inside else 0


def _connected(first: Tuple[int, int], layers: Sequence[Labels]) -> Set[Tuple[int, int]]:
    """All components that can be reached from one by moving within layers and turning between neighbouring ones."""
    turns = [_shared(layers[k], layers[(k + 1) % DIRECTIONS]) for k in range(DIRECTIONS)]
    found, todo = {first}, [first]
    while todo:
        k, component = todo.pop()
        left = {((k + 1) % DIRECTIONS, b) for a, b in turns[k] if a == component}
        right = {((k - 1) % DIRECTIONS, a) for a, b in turns[k - 1] if b == component}
        todo += (left | right) - found
        found |= left | right
    return found


def _shared(here: Labels, next_one: Labels) -> List[Tuple[int, int]]:
    """Pairs of components that have a place in common."""
    both = (here > 0) & (next_one > 0)
    pairs = np.unique(here[both].astype(np.int64) * 2**32 + next_one[both])
    return [(int(pair >> 32), int(pair & 0xFFFFFFFF)) for pair in pairs]
