# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the camera, the laser and the ground are: one file, read strictly and checked for sense."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import List, Literal, Optional, Tuple

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion._core import VISIBLE, Camera, project
from edgefusion.config import convert, read_toml
from edgefusion.errors import RefusedError
from edgefusion.types import read_only

Matrix = npt.NDArray[np.float64]
_Rows = List[List[float]]

# What a robot's sensors can be; the opening angle is that of the pinhole.
WIDTH_DEGREES = (5.0, 170.0)
OFFSET_MAX_M = 10.0
LATENCY_MAX_NS = 10_000_000_000


class CalibrationFile(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """calibration.toml. T_a_b maps coordinates of frame b into frame a; the laser is level where T_base_laser is
    absent. Latencies: from capture to the stamp that the sensor's data carries."""

    version: Literal[1]
    image_size: Tuple[int, int]
    K: _Rows
    distortion: List[float] = []
    T_camera_laser: _Rows
    T_base_laser: Optional[_Rows] = None
    laser_height_m: float
    camera_latency_ns: int = 0
    laser_latency_ns: int = 0


class _LaserToCamera(msgspec.Struct, forbid_unknown_fields=True):
    R: _Rows
    t: List[float]
    convention: str = ""


class FolderCalibrationFile(msgspec.Struct, forbid_unknown_fields=True):
    """calibration.json of a folder recording."""

    image_size: Tuple[int, int]
    K: _Rows
    laser_to_camera: _LaserToCamera
    laser_height_m: float
    distortion: List[float] = []


@dataclass(frozen=True)
class Calibration:
    """The geometry of the sensors.

    image_size: (width, height) [px]. K [3, 3], distortion: OpenCV's. T_camera_laser [4, 4] maps laser into camera
    coordinates, T_base_laser [4, 4] laser into base_link coordinates (mounting, also upside down).
    laser_height_m: of the scan plane above the ground, at the laser.

    Raises ValueError for a geometry that cannot be.
    """

    image_size: tuple[int, int]
    K: Matrix
    distortion: tuple[float, ...]
    T_camera_laser: Matrix
    T_base_laser: Matrix
    laser_height_m: float
    camera_latency_ns: int = 0
    laser_latency_ns: int = 0
    camera: Camera = field(init=False, repr=False, compare=False)
    to_ground: Matrix = field(init=False, repr=False, compare=False)
    """From a laser point straight down to the ground, in the laser's frame [m], [3]."""

    def __post_init__(self) -> None:
        if not 0 < self.laser_height_m < 10:
            raise ValueError(f"laser_height_m: expected above 0 and below 10 m, got {self.laser_height_m}")
        for name, shape in (("K", (3, 3)), ("T_camera_laser", (4, 4)), ("T_base_laser", (4, 4))):
            object.__setattr__(self, name, _matrix(name, getattr(self, name), shape))
        _check_image_size(self.image_size)
        _check_principal_point(self.K, self.image_size)
        _check_rigid("T_camera_laser", self.T_camera_laser)
        _check_rigid("T_base_laser", self.T_base_laser)
        for name in ("camera_latency_ns", "laser_latency_ns"):
            _check_latency(name, getattr(self, name))
        down = self.T_base_laser[:3, :3].T @ np.array([0.0, 0.0, -self.laser_height_m])
        object.__setattr__(self, "to_ground", read_only(down))
        object.__setattr__(self, "camera", Camera(self.K, list(self.distortion)))
        _check_field_of_view(self.K, self.image_size)
        _check_upright(self)
        _check_laser_in_view(self)


def load_calibration(path: Path) -> Calibration:
    """Reads calibration.toml, or the calibration.json of a folder recording. Raises RefusedError, one line."""
    try:
        return _from_json(path) if path.suffix == ".json" else _from_toml(path)
    except RefusedError:
        raise
    except ValueError as error:
        raise RefusedError(f"{path}: {error}") from error


def _from_toml(path: Path) -> Calibration:
    content = convert(read_toml(path), CalibrationFile, path)
    level = np.eye(4)
    level[2, 3] = content.laser_height_m
    return Calibration(
        image_size=content.image_size,
        K=content.K,  # type: ignore[arg-type]  # a matrix once it is checked
        distortion=tuple(content.distortion),
        T_camera_laser=content.T_camera_laser,  # type: ignore[arg-type]
        T_base_laser=level if content.T_base_laser is None else content.T_base_laser,  # type: ignore[arg-type]
        laser_height_m=content.laser_height_m,
        camera_latency_ns=content.camera_latency_ns,
        laser_latency_ns=content.laser_latency_ns,
    )


def _from_json(path: Path) -> Calibration:
    try:
        content = convert(json.loads(path.read_text(encoding="utf-8")), FolderCalibrationFile, path)
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror}") from error
    except (json.JSONDecodeError, RecursionError) as error:
        raise RefusedError(f"{path}: not JSON: {error}") from error
    T_camera_laser, T_base_laser = np.eye(4), np.eye(4)
    T_camera_laser[:3, :3] = _matrix("laser_to_camera.R", content.laser_to_camera.R, (3, 3))
    T_camera_laser[:3, 3] = _matrix("laser_to_camera.t", content.laser_to_camera.t, (3,))
    T_base_laser[2, 3] = content.laser_height_m
    return Calibration(
        image_size=content.image_size,
        K=content.K,  # type: ignore[arg-type]  # a matrix once it is checked
        distortion=tuple(content.distortion),
        T_camera_laser=T_camera_laser,
        T_base_laser=T_base_laser,
        laser_height_m=content.laser_height_m,
    )


def _matrix(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Matrix:
    try:
        matrix = np.array(values, float)
    except ValueError:
        raise ValueError(f"{name}: expected shape {list(shape)}, got rows of different length") from None
    if matrix.shape != shape:
        raise ValueError(f"{name}: expected shape {list(shape)}, got {list(matrix.shape)}")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name}: expected finite values")
    return read_only(matrix)


def _check_image_size(image_size: tuple[int, int]) -> None:
    if min(image_size) < 1:
        raise ValueError(f"image_size: expected [width, height] above 0, got {list(image_size)}")


def _check_principal_point(K: Matrix, image_size: tuple[int, int]) -> None:
    cx, cy = K[0, 2], K[1, 2]
    if not (0 <= cx < image_size[0] and 0 <= cy < image_size[1]):
        raise ValueError(f"K: expected the principal point inside {list(image_size)}, got ({cx:g}, {cy:g})")


def _check_rigid(name: str, T: Matrix) -> None:
    R = T[:3, :3]
    # Calibration files are rounded: 1e-3 is 0.06 degrees.
    if np.abs(R @ R.T - np.eye(3)).max() > 1e-3 or np.linalg.det(R) < 0:
        raise ValueError(f"{name}: expected a rotation (orthonormal, determinant +1), got {R.round(4).tolist()}")
    if (T[3] != (0, 0, 0, 1)).any():
        raise ValueError(f"{name}: expected [0, 0, 0, 1] as last row, got {T[3].tolist()}")
    offset_m = float(np.linalg.norm(T[:3, 3]))
    if offset_m > OFFSET_MAX_M:
        raise ValueError(f"{name}: expected a translation of at most {OFFSET_MAX_M:g} m, got {offset_m:g} m")


def _check_latency(name: str, latency_ns: int) -> None:
    if abs(latency_ns) > LATENCY_MAX_NS:
        raise ValueError(f"{name}: expected at most {LATENCY_MAX_NS} either way, got {latency_ns}")


def _check_field_of_view(K: Matrix, image_size: tuple[int, int]) -> None:
    fx, cx, width = float(K[0, 0]), float(K[0, 2]), image_size[0]
    degrees = np.degrees(np.arctan(cx / fx) + np.arctan((width - cx) / fx))
    least, most = WIDTH_DEGREES
    if not least <= degrees <= most:
        raise ValueError(
            f"K: expected a horizontal field of view of {least:g} to {most:g} degrees, got {degrees:.1f}, "
            f"for {fx:g} px of focal length and {width} px of width"
        )


def _check_upright(calibration: Calibration) -> None:
    """Boxes stand on the ground and are as wide as the scan: no camera that lies on its side."""
    down = calibration.T_camera_laser[:3, :3] @ (calibration.to_ground / calibration.laser_height_m)
    if down[1] < np.cos(np.radians(60)):
        raise ValueError(
            "T_camera_laser: expected the camera upright (the ground within 60 degrees of the image's down), "
            f"got {np.degrees(np.arccos(np.clip(down[1], -1, 1))):.0f} degrees"
        )


def _check_laser_in_view(calibration: Calibration) -> None:
    """A camera that no beam could ever appear in has a wrong extrinsic, most often transposed or inverted."""
    angles = np.radians(np.arange(0, 360, 0.5))
    points = np.concatenate(
        [r * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) for r in (0.5, 2.0, 8.0, 30.0)]
    )
    pixels, marks = project(points, calibration.camera, calibration.T_camera_laser)
    width, height = calibration.image_size
    x, y = pixels[marks == VISIBLE].T
    if not ((x >= 0) & (x < width) & (y >= 0) & (y < height)).any():
        raise ValueError("T_camera_laser: no beam between 0.5 and 30 m would fall into the image")
