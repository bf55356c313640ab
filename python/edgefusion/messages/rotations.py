# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Rotations as ROS has them: quaternions."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from edgefusion.messages.cdr import WireError
from edgefusion.messages.geometry_msgs import Quaternion

Matrix = npt.NDArray[np.float64]

LENGTH_TOLERANCE = 0.02
"""People write quaternions by hand, as (0.7, 0.7)."""
_SIGNS = np.array([[1, -1, -1], [-1, 1, -1], [-1, -1, 1], [1, 1, 1]])


def quaternion_of(R: Matrix) -> Quaternion:
    """Of a rotation [3, 3]; w is not negative."""
    # The largest of the four squares is at least 1/4, so that nothing is divided by little.
    squares = 1 + _SIGNS @ R.diagonal()
    differences = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    sums = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    rows = np.array([
        [squares[0], sums[0], sums[1], differences[0]],
        [sums[0], squares[1], sums[2], differences[1]],
        [sums[1], sums[2], squares[2], differences[2]],
        [differences[0], differences[1], differences[2], squares[3]],
    ])  # fmt: skip
    q = rows[squares.argmax()]
    x, y, z, w = (q * (math.copysign(1.0, q[3]) / np.linalg.norm(q))).tolist()
    return Quaternion(x, y, z, w)


def rotation_of(quaternion: Quaternion, name: str) -> Matrix:
    """The rotation [3, 3]. Raises WireError, naming what it is of, for one that is not of length 1."""
    q = (quaternion.x, quaternion.y, quaternion.z, quaternion.w)
    length = math.hypot(*q)
    if not abs(length - 1) <= LENGTH_TOLERANCE:
        raise WireError(f"{name}: expected a quaternion of length 1, got {q}")
    x, y, z, w = (value / length for value in q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
