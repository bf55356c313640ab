# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Size, rate and exposure of a V4L2 camera, as OpenCV passes them on."""

from __future__ import annotations

from typing import Protocol

import cv2

from edgefusion.config.camera import CameraConfig

MANUAL = 1
"""V4L2's mode of exposure with a set time."""
UNITS_PER_S = 10_000
"""V4L2 counts exposure in 0.1 ms."""


class Properties(Protocol):
    """The part of cv2.VideoCapture that is used here."""

    def set(self, propId: int, value: float) -> bool:
        """Whether the device took the value."""


def apply_settings(device: Properties, config: CameraConfig) -> list[str]:
    """Sets what is configured, in the order that drivers need; returns the names of what the device did not take."""
    return [name for name, property_id, value in _settings(config) if not device.set(property_id, value)]


def _settings(config: CameraConfig) -> list[tuple[str, int, float]]:
    """The format comes first: it limits sizes and rates. Then the mode of the exposure, which frees its time."""
    settings: list[tuple[str, int, float]] = []
    if config.fourcc is not None:
        settings.append(("fourcc", cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*config.fourcc)))
    if config.width is not None and config.height is not None:
        settings.append(("width", cv2.CAP_PROP_FRAME_WIDTH, config.width))
        settings.append(("height", cv2.CAP_PROP_FRAME_HEIGHT, config.height))
    if config.rate_hz is not None:
        settings.append(("rate_hz", cv2.CAP_PROP_FPS, config.rate_hz))
    if config.exposure_s is not None:
        settings.append(("manual exposure", cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL))
        settings.append(("exposure_s", cv2.CAP_PROP_EXPOSURE, max(1, round(config.exposure_s * UNITS_PER_S))))
    return settings
