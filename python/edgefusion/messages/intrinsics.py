# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a camera makes of what it sees, as far as CameraInfo tells it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.types import read_only


@dataclass(frozen=True)
class Intrinsics:
    """image_size: (width, height) [px]. K: float64 [3, 3]. distortion: OpenCV's, 0, 4, 5, 8, 12 or 14 coefficients."""

    image_size: tuple[int, int]
    K: npt.NDArray[np.float64]
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        K = np.asarray(self.K, float)
        if K.shape != (3, 3) or not np.isfinite(K).all() or not (K[0, 0] > 0 and K[1, 1] > 0):
            raise ValueError(f"K: expected finite numbers [3, 3] with focal lengths above 0, got {K.tolist()}")
        if not np.isfinite(self.distortion).all() or len(self.distortion) not in (0, 4, 5, 8, 12, 14):
            raise ValueError(f"distortion: expected 0, 4, 5, 8, 12 or 14 finite numbers, got {list(self.distortion)}")
        if not min(self.image_size) > 0:
            raise ValueError(f"image_size: expected above 0, got {self.image_size}")
        object.__setattr__(self, "K", read_only(K))
