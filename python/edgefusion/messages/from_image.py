# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures as CompressedImage."""

from __future__ import annotations

from edgefusion.messages.from_jpeg import from_jpeg
from edgefusion.messages.pictures import encode_jpeg
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Frame

QUALITY = 80
"""Of JPEG, if nothing else is said."""


def from_image(frame: Frame, stamper: Stamper, quality: int = QUALITY) -> CompressedImage:
    """As JPEG. quality: 1 to 100. Raises RefusedError for a picture that JPEG cannot hold."""
    return from_jpeg(frame.stamp_ns, encode_jpeg(frame.image, quality), stamper)
