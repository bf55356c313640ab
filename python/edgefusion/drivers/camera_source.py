# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures out of a child's pipe: with a header of their own, or bare and all of one size."""

from __future__ import annotations

import struct
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from edgefusion.clock import Clock
from edgefusion.drivers.camera_pipe import ChildPipe, PipeEndedError

HEADER = struct.Struct("<4sqII")
"""MAGIC, when the picture arrived [ns of CLOCK_MONOTONIC, which all processes share], height, width."""
MAGIC = b"EFP1"
LARGEST_PX = 8192


class Picture(NamedTuple):
    """A BGR picture uint8 [height, width, 3] and when it reached the computer."""

    arrival_ns: int
    image: npt.NDArray[np.uint8]


class PictureSource(Protocol):
    """What a camera reads from."""

    def read(self, timeout_s: float) -> Picture | None:
        """The next picture, or None if it is not complete within the time. Raises PipeEndedError at the end."""

    def close(self) -> None:
        """Lets go of the device, within about a second, whatever it hangs in."""


class StampedPictures:
    """Pictures of the capturing child, which stamps them as it gets them."""

    def __init__(self, pipe: ChildPipe) -> None:
        self._pipe, self._header = pipe, memoryview(bytearray(HEADER.size))
        self._arrival_ns = 0
        self._image: npt.NDArray[np.uint8] | None = None

    def read(self, timeout_s: float) -> Picture | None:
        """The next picture, or None if it is not complete within the time. Raises PipeEndedError at the end."""
        if self._image is None:
            if not self._pipe.fill(self._header, timeout_s):
                return None
            self._arrival_ns, self._image = _announced(bytes(self._header))
        if not self._pipe.fill(self._image.data.cast("B"), timeout_s):
            return None
        image, self._image = self._image, None
        return Picture(self._arrival_ns, image)

    def close(self) -> None:
        """Kills the child."""
        self._pipe.close()


def _announced(header: bytes) -> tuple[int, npt.NDArray[np.uint8]]:
    magic, arrival_ns, height, width = HEADER.unpack(header)
    if magic != MAGIC or not (0 < height <= LARGEST_PX and 0 < width <= LARGEST_PX):
        raise PipeEndedError(f"expected a picture's header, got {header.hex()}")
    return arrival_ns, np.empty((height, width, 3), np.uint8)


class BarePictures:
    """Pictures without headers, as GStreamer writes them: stamped when they are complete."""

    def __init__(self, pipe: ChildPipe, width: int, height: int, clock: Clock) -> None:
        self._pipe, self._clock = pipe, clock
        self._shape = (height, width, 3)
        self._image = np.empty(self._shape, np.uint8)

    def read(self, timeout_s: float) -> Picture | None:
        """The next picture, or None if it is not complete within the time. Raises PipeEndedError at the end."""
        if not self._pipe.fill(self._image.data.cast("B"), timeout_s):
            return None
        image, self._image = self._image, np.empty(self._shape, np.uint8)
        return Picture(self._clock(), image)

    def close(self) -> None:
        """Kills the child."""
        self._pipe.close()
