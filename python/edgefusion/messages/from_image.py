# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures as CompressedImage."""

from __future__ import annotations

from edgefusion.messages.frames import CAMERA_OPTICAL
from edgefusion.messages.pictures import encode_jpeg
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Frame

QUALITY = 80
"""Of JPEG, if nothing else is said."""


def from_image(frame: Frame, stamper: Stamper, quality: int = QUALITY) -> CompressedImage:
    """As JPEG. quality: 1 to 100. Raises RefusedError for a picture that JPEG cannot hold."""
    return from_jpeg(frame.stamp_ns, encode_jpeg(frame.image, quality), stamper)


def from_jpeg(stamp_ns: int, data: bytes, stamper: Stamper) -> CompressedImage:
    """A picture that is a JPEG already, captured then."""
    return CompressedImage(stamper.header(stamp_ns, CAMERA_OPTICAL), "jpeg", data)
