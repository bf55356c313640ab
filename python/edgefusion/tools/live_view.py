# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures as they come, on a page for a browser on this machine."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.sim.mjpeg_server import MjpegServer

QUALITY = 85
PATIENCE_S = 600.0


class LiveView(MjpegServer):
    """Serves the newest picture to everyone who looks, until it is closed. Raises RefusedError for a taken port."""

    def __enter__(self) -> LiveView:
        return self

    def wait_for_someone(self, patience_s: float = PATIENCE_S) -> None:
        """Returns when somebody looks. Raises RefusedError where nobody does."""
        if not self.watched.wait(patience_s):
            raise RefusedError(f"{self.url}: expected somebody to look within {patience_s / 60:g} minutes, got nobody")

    def show(self, picture: npt.NDArray[np.uint8]) -> None:
        """The newest picture from now on, BGR."""
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        self.put(data.tobytes())
