# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A JPEG as CompressedImage: for who has one, and needs no OpenCV for it."""

from __future__ import annotations

from edgefusion.messages.frames import CAMERA_OPTICAL
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.stamps import Stamper


def from_jpeg(stamp_ns: int, data: bytes, stamper: Stamper) -> CompressedImage:
    """A picture that is a JPEG already, captured then."""
    return CompressedImage(stamper.header(stamp_ns, CAMERA_OPTICAL), "jpeg", data)
