# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the simulated robot's sensors are and what its camera is; the fields are those of a calibration file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Pose2D, read_only

Matrix = npt.NDArray[np.float64]

# Laser axes (x forward, y left, z up) into camera axes (z forward, x right, y down).
_TO_OPTICAL = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])

_EXACT = 1e-6
"""How far a component of a rotation may be off."""


def rigid(R: npt.ArrayLike, t: npt.ArrayLike) -> Matrix:
    """The transform [4, 4] of a rotation [3, 3] and a translation [3]."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, t
    return read_only(T)


@dataclass(frozen=True)
class Rig:
    """The sensors on the base. By default a laser on the deck of a Pioneer 3-DX and a camera 0.25 m above it.

    image_size: (width, height) [px]. K [3, 3], distortion: OpenCV's. T_camera_laser, T_base_laser [4, 4] map laser
    coordinates into those of the camera and of base_link, whose origin is on the ground.

    The laser is level and upright, anywhere above the ground and turned anyhow about the vertical; the camera does not
    roll, so that the horizon is a row of its pictures. Raises RefusedError for anything else.
    """

    image_size: tuple[int, int] = (640, 480)
    K: Matrix = field(
        default_factory=lambda: read_only(np.array([[460.0, 0.0, 324.1], [0.0, 460.0, 235.2], [0.0, 0.0, 1.0]]))
    )
    distortion: tuple[float, ...] = (-0.06, 0.01, 0.0, 0.0, 0.0)
    T_camera_laser: Matrix = field(default_factory=lambda: rigid(_TO_OPTICAL, (0.0, 0.25, -0.03)))
    T_base_laser: Matrix = field(default_factory=lambda: rigid(np.eye(3), (0.10, 0.0, 0.35)))

    def __post_init__(self) -> None:
        if min(self.image_size) < 1:
            raise RefusedError(f"image_size: expected [width, height] above 0, got {list(self.image_size)}")
        if np.shape(self.K) != (3, 3):
            raise RefusedError(f"K: expected shape [3, 3], got {list(np.shape(self.K))}")
        for name in ("T_camera_laser", "T_base_laser"):
            _check_rigid(name, getattr(self, name))
        _check_level(self.T_base_laser)
        _check_no_roll(self.T_base_laser[:3, :3] @ self.T_camera_laser[:3, :3].T)

    @property
    def laser_height_m(self) -> float:
        """Of the scan plane above the ground."""
        return float(self.T_base_laser[2, 3])

    def T_world_camera(self, base: Pose2D) -> Matrix:
        """Maps camera coordinates into the world's, for a base that stands there."""
        T: Matrix = base.matrix() @ self.T_base_laser @ np.linalg.inv(self.T_camera_laser)
        return T

    def laser_pose(self, base: Pose2D) -> Pose2D:
        """The laser's pose in the world, for a base that stands there."""
        T = base.matrix() @ self.T_base_laser
        return Pose2D(float(T[0, 3]), float(T[1, 3]), math.atan2(T[1, 0], T[0, 0]))


def _check_rigid(name: str, T: Matrix) -> None:
    if np.shape(T) != (4, 4):
        raise RefusedError(f"{name}: expected shape [4, 4], got {list(np.shape(T))}")
    R = T[:3, :3]
    if not (np.abs(R @ R.T - np.eye(3)).max() < _EXACT and np.linalg.det(R) > 0 and (T[3] == (0, 0, 0, 1)).all()):
        raise RefusedError(f"{name}: expected a rotation and a translation, got {np.round(T, 4).tolist()}")


def _check_level(T_base_laser: Matrix) -> None:
    """Scans are cut out of the world level, and their beams run counter-clockwise for one who looks from above."""
    up = T_base_laser[:3, 2]
    if not np.abs(up - (0, 0, 1)).max() < _EXACT:
        raise RefusedError(f"T_base_laser: expected a level, upright laser, got one with {_row(up)} as its up")
    if not 0 < T_base_laser[2, 3] < math.inf:
        raise RefusedError(f"T_base_laser: expected a laser above the ground, got a height of {T_base_laser[2, 3]:g} m")


def _check_no_roll(R_base_camera: Matrix) -> None:
    right, down = R_base_camera[:, 0], R_base_camera[:, 1]
    if not (abs(right[2]) < _EXACT and down[2] < -_EXACT):
        raise RefusedError(
            f"T_camera_laser: expected a camera without roll, the ground below, got one with {_row(right)} as its "
            f"right and {_row(down)} as its down"
        )


def _row(axis: Matrix) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in axis) + ")"
