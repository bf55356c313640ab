# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures from Image, in the encodings that cameras have."""

from __future__ import annotations

from types import MappingProxyType
from typing import Mapping, Optional, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.messages.cdr import WireError
from edgefusion.messages.sensor_msgs import Image
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Frame

_ENCODINGS: Mapping[str, Tuple[int, Optional[int]]] = MappingProxyType(
    {
        "bgr8": (3, None),
        "8UC3": (3, None),
        "rgb8": (3, cv2.COLOR_RGB2BGR),
        "bgra8": (4, cv2.COLOR_BGRA2BGR),
        "rgba8": (4, cv2.COLOR_RGBA2BGR),
        "mono8": (1, cv2.COLOR_GRAY2BGR),
        "8UC1": (1, cv2.COLOR_GRAY2BGR),
        # OpenCV names a Bayer pattern by the second row's second and third pixel, ROS by the first row's first two.
        "bayer_rggb8": (1, cv2.COLOR_BayerBG2BGR),
        "bayer_bggr8": (1, cv2.COLOR_BayerRG2BGR),
        "bayer_gbrg8": (1, cv2.COLOR_BayerGR2BGR),
        "bayer_grbg8": (1, cv2.COLOR_BayerGB2BGR),
        "uyvy": (2, cv2.COLOR_YUV2BGR_UYVY),
        "yuv422": (2, cv2.COLOR_YUV2BGR_UYVY),
        "yuyv": (2, cv2.COLOR_YUV2BGR_YUY2),
        "yuv422_yuy2": (2, cv2.COLOR_YUV2BGR_YUY2),
    }
)
"""Bytes of a pixel, and what makes BGR of it."""


def to_raw_image(message: Image, stamper: Stamper) -> Frame:
    """Raises WireError for an encoding that is not of eight bits, and for data that are not of the size they should."""
    if message.encoding not in _ENCODINGS:
        raise WireError(f"encoding: expected one of {', '.join(_ENCODINGS)}, got {message.encoding!r}")
    channels, conversion = _ENCODINGS[message.encoding]
    pixels = _pixels(message, channels)
    try:
        image = pixels if conversion is None else cv2.cvtColor(pixels, conversion)
    except cv2.error as error:
        raise WireError(f"{message.encoding}: {message.width}x{message.height} cannot be: {error.err}") from error
    return Frame(stamper.to_ns(message.header.stamp), np.ascontiguousarray(image, np.uint8))


def _pixels(message: Image, channels: int) -> npt.NDArray[np.uint8]:
    """uint8 [height, width, channels], or [height, width] of one channel."""
    height, width, row = message.height, message.width, message.width * channels
    if not height or not width:
        raise WireError(f"image: expected pixels, got {width}x{height}")
    if message.step < row or len(message.data) != message.step * height:
        raise WireError(
            f"image: {width}x{height} {message.encoding} with a step of {message.step}: expected a step of {row} or "
            f"more and {height} times as many bytes, got {len(message.data)}"
        )
    rows = np.frombuffer(message.data, np.uint8).reshape(height, message.step)[:, :row]
    return rows.reshape(height, width, channels) if channels > 1 else rows
