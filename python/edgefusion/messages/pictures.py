# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures as files, JPEG or PNG, from somebody who may not mean well."""

from __future__ import annotations

import struct
from typing import Optional, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import WireError

MOST_PIXELS = 1 << 26
"""Of a picture: 8192 x 8192. A file of a few bytes may claim to be a thousand times larger than that."""

Size = Tuple[int, int]
_JPEG, _PNG = b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n"
_ENDS = {_JPEG: b"\xff\xd9", _PNG: b"IEND\xaeB`\x82"}
_TRAILING = 1024
"""Bytes at the end in which the end may be: cameras pad, and some append notes of their own."""
_FRAME_HEADERS = set(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""JPEG's markers that are followed by the picture's size."""


def encode_jpeg(image: npt.NDArray[np.uint8], quality: int) -> bytes:
    """quality: 1 to 100. Raises RefusedError for a picture that JPEG cannot hold."""
    if not 1 <= quality <= 100:
        raise RefusedError(f"quality: expected 1 to 100, got {quality}")
    try:
        done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    except cv2.error as error:
        raise RefusedError(f"picture: JPEG cannot hold {list(image.shape)}: {error.err}") from error
    if not done:
        raise RefusedError(f"picture: JPEG cannot hold {list(image.shape)}")
    return data.tobytes()


def decode_picture(data: bytes) -> npt.NDArray[np.uint8]:
    """BGR uint8 [height, width, 3]. Raises WireError for what is no whole JPEG or PNG, or too large."""
    size = picture_size(data)
    if size is None:
        raise WireError(f"picture: expected a JPEG or PNG, got {len(data)} bytes that begin with {data[:8].hex()}")
    if not 0 < size[0] * size[1] <= MOST_PIXELS:
        raise WireError(f"picture: expected at most {MOST_PIXELS} pixels, got {size[0]}x{size[1]}")
    if not any(data.startswith(begin) and end in data[-_TRAILING:] for begin, end in _ENDS.items()):
        raise WireError(f"picture: truncated: {len(data)} bytes without its end")
    image = _decoded(data)
    if image is None:
        raise WireError(f"picture: cannot decode its {len(data)} bytes")
    return image


def picture_size(data: bytes) -> Optional[Size]:
    """(width, height) [px], as a JPEG or PNG claims; None where it does not, or is neither."""
    if data.startswith(_PNG) and data[12:16] == b"IHDR" and len(data) >= 24:
        width, height = struct.unpack_from(">II", data, 16)
        return width, height
    return _jpeg_size(data) if data.startswith(_JPEG) else None


def _jpeg_size(data: bytes) -> Optional[Size]:
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if marker in _FRAME_HEADERS:
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        at += 1 if marker == 0xFF else 2 + length  # any number of 0xFF may fill the gap before a marker
    return None


def _decoded(data: bytes) -> Optional[npt.NDArray[np.uint8]]:
    try:
        # A note that the picture be shown turned is not for us: its pixels are where the calibration has them.
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
        return cv2.imdecode(np.frombuffer(data, np.uint8), flags)  # type: ignore[return-value]
    except cv2.error:
        return None
