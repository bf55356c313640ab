# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where in the image the laser's points are, for viewers that have no C++ core."""

from __future__ import annotations

from typing import Mapping, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.messages.frames import BASE_LINK, CAMERA_OPTICAL, LASER
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.transform import FrameTransform
from edgefusion.types import Scan

Array = npt.NDArray[np.float64]

NEAREST_M = 0.05
ROBOT = (BASE_LINK, "base_footprint")
"""One of these is what all of a robot is mounted on."""
MARGIN = 0.3
"""By so much of its size outside the image a point may be for a camera without distortion: the polynomial brings some
from far outside back into it."""


class Pixels(NamedTuple):
    """uv: float64 [n, 2], in the image; ranges_m: float64 [n]."""

    uv: Array
    ranges_m: Array


def points(scan: Scan) -> Array:
    """The places of the beams that hit something, float64 [n, 3], in the laser's frame."""
    hit = np.isfinite(scan.ranges_m)
    ranges_m, angles = scan.ranges_m[hit].astype(float), scan.angles[hit]
    return np.stack([ranges_m * np.cos(angles), ranges_m * np.sin(angles), np.zeros(len(ranges_m))], axis=1)


def to_base(frames: Mapping[str, FrameTransform], frame: str) -> Array | None:
    """The transform [4, 4] of a frame's coordinates into the robot's; None where it is not known how it is mounted."""
    found = _to_root(frames, frame)
    return found.T if found is not None and found.frame in ROBOT else None


def camera_from_laser(
    frames: Mapping[str, FrameTransform], laser: str = LASER, camera: str = CAMERA_OPTICAL
) -> Array | None:
    """T_camera_laser [4, 4]; None where it is not known."""
    of_laser, of_camera = _to_root(frames, laser), _to_root(frames, camera)
    if of_laser is None or of_camera is None or of_laser.frame != of_camera.frame:
        return None
    return np.linalg.inv(of_camera.T) @ of_laser.T


class _Root(NamedTuple):
    """frame: that which is mounted on no other; T: into its coordinates."""

    frame: str
    T: Array


def _to_root(frames: Mapping[str, FrameTransform], frame: str) -> _Root | None:
    """None where frames go round in a circle."""
    T = np.eye(4)
    for _ in range(len(frames) + 1):
        if frame not in frames:
            return _Root(frame, T)
        T = frames[frame].T_parent_child @ T
        frame = frames[frame].parent
    return None


def pixels(scan: Scan, camera: Intrinsics, T_camera_laser: Array) -> Pixels:
    """Of the points that the camera sees."""
    places = points(scan)
    seen = places @ T_camera_laser[:3, :3].T + T_camera_laser[:3, 3]
    size = np.array(camera.image_size, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = (seen @ camera.K.T)[:, :2] / seen[:, 2:]
        ahead = (seen[:, 2] > NEAREST_M) & ((straight > -MARGIN * size) & (straight < (1 + MARGIN) * size)).all(axis=1)
    if not ahead.any():
        return Pixels(np.empty((0, 2)), np.empty(0))
    distortion = np.array(camera.distortion)
    uv = cv2.projectPoints(seen[ahead], np.zeros(3), np.zeros(3), camera.K, distortion)[0][:, 0].astype(np.float64)
    inside = ((uv >= 0) & (uv < size)).all(axis=1)
    return Pixels(uv[inside], np.linalg.norm(places[ahead][inside], axis=1))
