# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Intrinsics from CameraInfo."""

from __future__ import annotations

import numpy as np

from edgefusion.messages.cdr import WireError
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.sensor_msgs import CameraInfo

_MODELS = {"plumb_bob": (0, 4, 5), "rational_polynomial": (8, 12, 14), "": (0,)}
"""How many coefficients a model of distortion has."""


def to_camera_info(message: CameraInfo) -> Intrinsics:
    """Of the unrectified picture. Raises WireError for a camera that is not calibrated, a fisheye, and one that gives
    a part of its picture, or a smaller one."""
    if message.distortion_model not in _MODELS:
        raise WireError(
            f"camera_info: distortion_model: expected plumb_bob or rational_polynomial, "
            f"got {message.distortion_model!r}"
        )
    if len(message.d) not in _MODELS[message.distortion_model]:
        raise WireError(f"camera_info: d: {len(message.d)} coefficients are not {message.distortion_model!r}")
    _check_whole(message)
    try:
        return Intrinsics((message.width, message.height), np.reshape(message.k, (3, 3)), tuple(message.d))
    except ValueError as error:
        raise WireError(f"camera_info: {error}") from None


def _check_whole(message: CameraInfo) -> None:
    if max(message.binning_x, message.binning_y) > 1:
        raise WireError(f"camera_info: expected no binning, got {message.binning_x}x{message.binning_y}")
    roi = message.roi
    cut = (roi.x_offset, roi.y_offset, roi.width, roi.height)
    if cut not in ((0, 0, 0, 0), (0, 0, message.width, message.height)):
        raise WireError(f"camera_info: expected the whole picture, got a region {cut}")
