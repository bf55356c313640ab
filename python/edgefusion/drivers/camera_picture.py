# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a camera sees: black, white and covered pictures, and a picture that is the same again and again.

A covered lens gives what is smooth everywhere: light that leaks round a finger has gradients, but no edges. A robot
that stands with its camera before a bare wall sees as little, and is told the same.
"""

from __future__ import annotations

from enum import Enum

import cv2
import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]

CELLS = (80, 60)
"""Columns and rows of the small picture that is judged: an average over so many pixels hides the sensor's noise."""
BLACK_LEVEL = 16
WHITE_LEVEL = 240
EDGE = 6
"""Grey levels between neighbouring cells: an edge has more, noise and a smooth gradient less."""
SHARE = 1.0
"""Percent of the cells that may be otherwise: hot pixels, a slit of light."""


class Sight(Enum):
    """What a picture shows of the camera that took it."""

    CLEAR = "clear"
    BLACK = "black"
    WHITE = "white"
    COVERED = "covered"


def sight(image: Image) -> Sight:
    """What a BGR picture uint8 [height, width, 3] shows of its camera."""
    cells = _cells(image)
    darkest, brightest = np.percentile(cells, (SHARE, 100 - SHARE))
    if brightest < BLACK_LEVEL:
        return Sight.BLACK
    if darkest > WHITE_LEVEL:
        return Sight.WHITE
    steps = np.concatenate([np.abs(np.diff(cells, axis=axis)).ravel() for axis in (0, 1)])
    return Sight.COVERED if np.percentile(steps, 100 - SHARE) < EDGE else Sight.CLEAR


def _cells(image: Image) -> npt.NDArray[np.float32]:
    small = cv2.resize(image, CELLS, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(small, cv2.COLOR_BGR2GRAY), np.float32)


class Repetition:
    """For how long the same picture has come, byte by byte: the noise of a sensor makes any two differ."""

    def __init__(self) -> None:
        self._image: Image | None = None
        self._since_ns = 0

    def lasts_ns(self, stamp_ns: int, image: Image) -> int:
        """Takes the next picture; returns how long before it the first of its likeness came: 0 for a new one."""
        if self._image is None or not np.array_equal(self._image, image):
            self._image, self._since_ns = image, stamp_ns
        return stamp_ns - self._since_ns
