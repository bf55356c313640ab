# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From the settings of a camera to a child that captures it."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import msgspec

from edgefusion.clock import Clock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_pipe import ChildPipe, PipeEndedError
from edgefusion.drivers.camera_source import BarePictures, PictureSource, StampedPictures

CAPTURE = (sys.executable, "-m", "edgefusion.drivers.camera_capture")
KEEP_STDOUT_CLEAN = ("sh", "-c", 'exec "$0" "$@" 3>&1 1>&2')
"""Plug-ins print to stdout, also NVIDIA's for CSI cameras: pictures go through descriptor 3, the rest to stderr."""


def open_source(config: CameraConfig, clock: Clock) -> PictureSource:
    """Starts to capture; the first picture comes later. Raises PipeEndedError where it cannot."""
    if config.is_csi:
        assert config.width is not None and config.height is not None
        pipe = ChildPipe([*KEEP_STDOUT_CLEAN, *gstreamer_command(config)])
        return BarePictures(pipe, config.width, config.height, clock)
    path = device_path(config)
    if path is not None and not path.exists():  # sooner than a child can say it, and for nothing
        raise PipeEndedError(f"{path}: not there")
    # Not on the command line, which everyone on the machine can read: a URL may hold a password.
    return StampedPictures(ChildPipe(CAPTURE, msgspec.json.encode(config) + b"\n"))


def device_path(config: CameraConfig) -> Path | None:
    """The file that must be there, or None for what comes from elsewhere."""
    if isinstance(config.source, int):
        return Path(f"/dev/video{config.source}")
    return None if config.is_csi or "://" in config.source else Path(config.source)


def gstreamer_command(config: CameraConfig) -> list[str]:
    """The command that writes the pictures of a CSI camera, BGR line by line, to descriptor 3."""
    assert config.rate_hz is not None
    rate = f"{round(config.rate_hz * 1000)}/1000"
    size = f"width={config.width},height={config.height},framerate={rate}"
    sensor = ["nvarguscamerasrc", f"sensor-id={config.csi_sensor}"]
    if config.exposure_s is not None:
        exposure_ns = round(config.exposure_s * 1e9)
        sensor.append(f"exposuretimerange={exposure_ns} {exposure_ns}")
    elements = [
        sensor,
        [f"video/x-raw(memory:NVMM),{size}"],
        ["nvvidconv"],
        ["video/x-raw,format=BGRx"],
        ["videoconvert"],
        ["video/x-raw,format=BGR"],
        # A reader that is late gets the newest picture, not the oldest.
        ["queue", "leaky=downstream", "max-size-buffers=1"],
        ["fdsink", "fd=3", "sync=false"],
    ]
    words = [word for element in elements for word in (*element, "!")]
    return [config.gst_launch, "-q", *words[:-1]]


def source_name(config: CameraConfig) -> str:
    """The source as it may be shown: without the name and password that a URL may hold."""
    if isinstance(config.source, int):
        return str(device_path(config))
    return re.sub(r"//[^/@]*@", "//", config.source)
