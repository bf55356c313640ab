# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The camera's lens: a pinhole picture that covers all that the distorted one shows, and the way from it to that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion._core import Camera, project
from edgefusion.sim.rig import Matrix, Rig

Image = npt.NDArray[Any]
Maps = Tuple[Image, ...]

SUPERSAMPLING = 2
"""Rendered pixels per pixel of the image, each way: the rasterizer snaps to whole pixels and draws hard edges."""

_GRID_PX, _ITERATIONS = 16, 60


@dataclass(frozen=True)
class Lens:
    """size: (width, height) of the rendered pinhole picture; focal, cx, cy: its intrinsics, pixel centres at whole
    numbers as in OpenCV. smooth, nearest: where each pixel of the image (supersampled) lies in the rendered one, as
    OpenCV's remap takes it; empty where the camera is a pinhole and the two are the same."""

    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    smooth: Maps = ()
    nearest: Maps = ()

    def picture(self, rendered: Image) -> Image:
        """The supersampled image of a rendered picture."""
        return _mapped(rendered, self.smooth, cv2.INTER_LINEAR)

    def mask(self, rendered: Image) -> Image:
        """The same for numbers, between which there is nothing."""
        return _mapped(rendered, self.nearest, cv2.INTER_NEAREST)


def _mapped(rendered: Image, maps: Maps, interpolation: int) -> Image:
    if not maps:
        return rendered
    return np.asarray(cv2.remap(rendered, maps[0], maps[1], interpolation, borderMode=cv2.BORDER_REPLICATE))


def lens_of(rig: Rig) -> Lens:
    """The lens of a rig's camera."""
    width, height = (SUPERSAMPLING * side for side in rig.image_size)
    # Centres of pixels are at whole numbers: the picture begins half a pixel before the first.
    K = np.asarray(rig.K, float).copy()
    K[:2, :2] *= SUPERSAMPLING
    K[:2, 2] = SUPERSAMPLING * (K[:2, 2] + 0.5) - 0.5
    focal, centre = (float(K[0, 0]), float(K[1, 1])), (float(K[0, 2]), float(K[1, 2]))
    if not np.any(rig.distortion):
        return Lens((width, height), focal, centre)
    source = _undistorted(width, height, K, rig.distortion)
    low = np.floor(source.reshape(-1, 2).min(axis=0)) - 1
    high = np.ceil(source.reshape(-1, 2).max(axis=0)) + 1
    size = (int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1)
    shifted_centre = (centre[0] - float(low[0]), centre[1] - float(low[1]))
    return Lens(size, focal, shifted_centre, _maps(source - low, False), _maps(source - low, True))


def _maps(source: Matrix, nearest: bool) -> Maps:
    """OpenCV's fixed point, which takes half the time of floats."""
    x, y = (np.ascontiguousarray(source[..., i], np.float32) for i in (0, 1))
    whole, rest = cv2.convertMaps(x, y, cv2.CV_16SC2, nninterpolation=nearest)
    return np.asarray(whole), np.empty(0, np.uint16) if nearest else np.asarray(rest)


def _undistorted(width: int, height: int, K: Matrix, distortion: tuple[float, ...]) -> Matrix:
    """Where a pinhole camera of the same K would see each pixel, [height, width, 2]."""
    # Solved on a coarse grid that reaches beyond the picture: in between the lens is smooth. What is interpolated is
    # the shift, since OpenCV's cubic bends straight lines: positions would ripple by 0.8 pixels.
    columns, rows = (np.arange(-_GRID_PX, side + 3 * _GRID_PX, _GRID_PX, dtype=float) for side in (width, height))
    x, y = np.meshgrid(columns, rows)
    focal, centre = K.diagonal()[:2], K[:2, 2]
    wanted = (np.stack([x, y], axis=-1).reshape(-1, 2) - centre) / focal
    camera = Camera(np.eye(3), list(distortion))
    found = wanted.copy()
    for _ in range(_ITERATIONS):
        seen, _marks = project(np.column_stack([found, np.ones(len(found))]), camera, np.eye(4))
        found += np.where(np.isfinite(seen), wanted - seen, 0.0)  # beyond the lens's reach nothing is to be seen
    shift = ((found - wanted) * focal).reshape(len(rows), len(columns), 2).astype(np.float32)
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    smooth = cv2.remap(shift, x / _GRID_PX + 1, y / _GRID_PX + 1, cv2.INTER_CUBIC)
    return np.asarray(np.stack([x, y], axis=-1) + smooth, float)
