# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The child that captures with OpenCV: settings come as JSON on its standard input, pictures go to its output.

It captures in one thread and releases nothing: any failure ends it, with the reason as its last line, and so does the
end of its standard input, that is its parent's.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import IO, Callable, NoReturn

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_open import source_name
from edgefusion.drivers.camera_source import HEADER, MAGIC
from edgefusion.drivers.camera_v4l2 import apply_settings


def main() -> NoReturn:
    """Captures until something fails."""
    out = private_stdout()
    config = msgspec.json.decode(sys.stdin.buffer.readline(), type=CameraConfig)
    threading.Thread(target=_end_with_the_parent, daemon=True).start()
    try:
        capture(config, out)
    except (CaptureError, OSError, cv2.error) as error:
        print(error, file=sys.stderr, flush=True)
    os._exit(1)


class CaptureError(Exception):
    """Why no more pictures come."""


def capture(config: CameraConfig, out: IO[bytes]) -> NoReturn:
    """Writes picture after picture, each with its header. Raises CaptureError when there are no more."""
    name = source_name(config)
    opened = _opened(config, name)
    wait = _pace(opened, config)
    while True:
        if not opened.grab():
            raise CaptureError(f"{name}: no more pictures")
        # Before it is decoded, which takes milliseconds.
        arrival_ns = time.monotonic_ns()
        good, image = opened.retrieve()
        if not good:
            raise CaptureError(f"{name}: a picture that cannot be decoded")
        _write(out, arrival_ns, _checked(np.asarray(image), config, name))
        wait()


def _opened(config: CameraConfig, name: str) -> cv2.VideoCapture:
    opened = cv2.VideoCapture(config.source, cv2.CAP_V4L2 if config.is_v4l2 else cv2.CAP_FFMPEG)
    if not opened.isOpened():
        raise CaptureError(f"{name}: cannot be opened")
    if config.is_v4l2:
        refused = apply_settings(opened, config)
        if refused:
            raise CaptureError(f"{name}: does not take {', '.join(refused)}")
    return opened


def _pace(opened: cv2.VideoCapture, config: CameraConfig) -> Callable[[], None]:
    """What to wait for between pictures: a file would be read at once, cameras and URLs come when they come."""
    if not config.is_file:
        return lambda: None
    rate_hz = config.rate_hz or opened.get(cv2.CAP_PROP_FPS) or 30.0
    return lambda: time.sleep(1 / rate_hz)


def _checked(image: npt.NDArray[np.generic], config: CameraConfig, name: str) -> npt.NDArray[np.uint8]:
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise CaptureError(f"{name}: expected pictures of three bytes a pixel, got {image.dtype} {image.shape}")
    height, width = image.shape[:2]
    if config.width is not None and (width, height) != (config.width, config.height):
        raise CaptureError(f"{name}: expected pictures of {config.width}x{config.height}, got {width}x{height}")
    return np.ascontiguousarray(image, np.uint8)


def _write(out: IO[bytes], arrival_ns: int, image: npt.NDArray[np.uint8]) -> None:
    out.write(HEADER.pack(MAGIC, arrival_ns, *image.shape[:2]))
    out.write(image.data.cast("B"))
    out.flush()


def private_stdout() -> IO[bytes]:
    """The pipe to the parent; what libraries print to stdout goes to stderr instead."""
    pipe = os.dup(1)
    os.dup2(2, 1)
    return os.fdopen(pipe, "wb")


def _end_with_the_parent() -> None:
    while os.read(0, 1):
        pass
    os._exit(0)


if __name__ == "__main__":
    cv2.setNumThreads(1)
    main()
