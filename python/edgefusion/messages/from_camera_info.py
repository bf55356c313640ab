# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Intrinsics as CameraInfo."""

from __future__ import annotations

from edgefusion.messages.frames import CAMERA_OPTICAL
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.sensor_msgs import CameraInfo
from edgefusion.messages.stamps import Stamper

_PLUMB_BOB = 5
"""Coefficients of that model; ROS calls all that has more rational."""


def from_camera_info(stamp_ns: int, camera: Intrinsics, stamper: Stamper) -> CameraInfo:
    """Of the picture of that stamp. It is not rectified, nor cut, nor binned."""
    (width, height), K = camera.image_size, camera.K
    simple = len(camera.distortion) <= _PLUMB_BOB
    return CameraInfo(
        stamper.header(stamp_ns, CAMERA_OPTICAL),
        height,
        width,
        "plumb_bob" if simple else "rational_polynomial",
        [*camera.distortion, *[0.0] * (_PLUMB_BOB - len(camera.distortion))],
        K.ravel().tolist(),
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        [*K[0].tolist(), 0.0, *K[1].tolist(), 0.0, *K[2].tolist(), 0.0],
    )
