# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures from CompressedImage."""

from __future__ import annotations

from edgefusion.messages.pictures import decode_picture
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Frame


def to_image(message: CompressedImage, stamper: Stamper) -> Frame:
    """Raises WireError for a picture that is no whole JPEG or PNG, whatever its format is called."""
    return Frame(stamper.to_ns(message.header.stamp), decode_picture(message.data))
