# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A scan as a picture: of braille characters for a terminal, or in a file."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Scan

ROWS = 19
"""Of characters, each of two by four dots; four times as many columns hold a half circle."""

_BRAILLE = 0x2800
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
_SHARE = 95
"""Percent of the ranges are inside of the plot."""

_PICTURE_PX, _BORDER_PX = 900, 40


def _points(scan: Scan) -> npt.NDArray[np.float64]:
    """What was met, in the laser's frame, float64[k, 2]."""
    met = np.isfinite(scan.ranges_m)
    ranges, angles = scan.ranges_m[met].astype(float), scan.angles[met]
    return np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])


def _reach_m(points: npt.NDArray[np.float64]) -> float:
    """How far the plot goes: a round number of metres."""
    if not len(points):
        return 1.0
    return float(max(1.0, np.ceil(np.percentile(np.hypot(points[:, 0], points[:, 1]), _SHARE))))


def scan_lines(scan: Scan, rows: int = ROWS) -> list[str]:
    """So many lines of text, and one more: ahead is up, the scanner is the caret below, the scale is beside it."""
    points, columns = _points(scan), 4 * rows
    reach_m = _reach_m(points)
    dots = np.zeros((4 * rows, 2 * columns), np.int64)
    per_m = (4 * rows - 1) / reach_m
    column = np.rint(columns - points[:, 1] * per_m).astype(int)
    row = np.rint(4 * rows - 1 - points[:, 0] * per_m).astype(int)
    inside = (column >= 0) & (column < 2 * columns) & (row >= 0) & (row < 4 * rows)
    dots[row[inside], column[inside]] = 1
    cells = (dots.reshape(rows, 4, columns, 2) * _BITS[None, :, None, :]).sum(axis=(1, 3))
    lines = ["".join(chr(_BRAILLE + cell) for cell in line) for line in cells]
    scale = f"{reach_m:g} m to the top"
    return [*lines, f"{'^':>{columns // 2 + 1}}{scale:>{columns // 2 - 1}}"]


def scan_picture(scan: Scan, path: Path) -> None:
    """The same as a PNG, with circles a metre apart. Raises RefusedError where it cannot be written."""
    points = _points(scan)
    reach_m = _reach_m(points)
    per_m = (_PICTURE_PX / 2 - _BORDER_PX) / reach_m
    height = _PICTURE_PX // 2 + _BORDER_PX
    image = np.full((height, _PICTURE_PX, 3), 255, np.uint8)
    here = (_PICTURE_PX // 2, height - _BORDER_PX)
    for metre in range(1, int(reach_m) + 1):
        cv2.ellipse(image, here, (int(metre * per_m),) * 2, 0, 180, 360, (225, 225, 225), 1, cv2.LINE_AA)
        at = (here[0] + int(metre * per_m) - 24, here[1] + 18)
        cv2.putText(image, f"{metre} m", at, cv2.FONT_HERSHEY_SIMPLEX, 0.4, (120, 120, 120), 1, cv2.LINE_AA)
    cv2.circle(image, here, 5, (0, 0, 0), -1, cv2.LINE_AA)
    for x_m, y_m in points:
        at = (round(here[0] - y_m * per_m), round(here[1] - x_m * per_m))
        cv2.circle(image, at, 2, (180, 60, 30), -1, cv2.LINE_AA)
    try:
        written = cv2.imwrite(str(path), image)
    except cv2.error:
        written = False
    if not written:
        raise RefusedError(f"{path}: expected a place to write to, and nothing was written")
