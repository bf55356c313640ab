# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a real camera adds to a clean picture: exposure, white balance, vignetting, motion blur, noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError

Image = npt.NDArray[np.uint8]
Factors = npt.NDArray[np.float64]
Rng = np.random.Generator

_NS_PER_S = 1e9


@dataclass(frozen=True)
class CameraSpec:
    """exposure_ns: how long the shutter is open. gain_sigma, tint_sigma: spread of the brightness and of the colours'
    balance from take to take. shot, read: noise in grey levels, of a pixel at 255 and of a black one. vignetting: how
    much darker the corners are, as a share."""

    exposure_ns: int = 12_000_000
    gain_sigma: float = 0.08
    tint_sigma: float = 0.02
    shot: float = 4.0
    read: float = 1.5
    vignetting: float = 0.12

    def __post_init__(self) -> None:
        # Half of it before the stamp, half after: 1 ns has no halves.
        if not 2 <= self.exposure_ns < math.inf:
            raise RefusedError(f"exposure_ns: expected at least 2, got {self.exposure_ns}")
        for name in ("gain_sigma", "tint_sigma", "shot", "read"):
            if not 0 <= getattr(self, name) < math.inf:
                raise RefusedError(f"{name}: expected a finite number of at least 0, got {getattr(self, name)}")
        if not 0 <= self.vignetting <= 1:
            raise RefusedError(f"vignetting: expected a share from 0 to 1, got {self.vignetting}")


def balance(spec: CameraSpec, rng: Rng) -> Factors:
    """Brightness and the colours' balance of one take: a factor for each of B, G, R, [3]."""
    return np.asarray(math.exp(rng.normal(0, spec.gain_sigma)) * np.exp(rng.normal(0, spec.tint_sigma, 3)))


def exposed(
    spec: CameraSpec, clean: Image, focal_px: float, yaw_rate_radps: float, rng: Rng, factors: Factors | None = None
) -> Image:
    """The picture that the camera delivers, BGR uint8; the same state of the generator gives the same bytes.

    yaw_rate_radps: of the camera while the shutter is open; driving straight blurs less than a pixel. factors: of
    `balance`, for takes that share them; by default this take has its own.
    """
    blurred = _turned(clean, focal_px * abs(yaw_rate_radps) * spec.exposure_ns / _NS_PER_S)
    gain = balance(spec, rng) if factors is None else factors
    light = blurred * (gain * _falloff(clean.shape[0], clean.shape[1], spec.vignetting)).astype(np.float32)
    sigma = np.sqrt(spec.read**2 + spec.shot**2 * np.clip(light, 0, 255) / 255)
    noise = rng.standard_normal(light.shape, np.float32)
    return np.asarray(np.clip(light + sigma * noise + 0.5, 0, 255), np.uint8)


def _turned(image: Image, length_px: float) -> npt.NDArray[np.float32]:
    """Smeared along the rows by so many pixels."""
    smooth = image.astype(np.float32)
    if length_px < 0.1:
        return smooth
    reach = math.ceil(length_px / 2)
    # A box of fractional length, its ends weighted by how much of them it covers.
    offsets = np.arange(-reach, reach + 1)
    kernel = np.clip(length_px / 2 + 0.5 - np.abs(offsets), 0, 1)
    return np.asarray(cv2.filter2D(smooth, -1, (kernel / kernel.sum())[None], borderType=cv2.BORDER_REPLICATE))


def _falloff(height: int, width: int, vignetting: float) -> npt.NDArray[np.float64]:
    """Factors [height, width, 1]: 1 in the middle, 1 - vignetting in the corners."""
    y, x = np.linspace(-1, 1, height)[:, None], np.linspace(-1, 1, width)[None, :]
    falloff: npt.NDArray[np.float64] = (1 - vignetting * (x * x + y * y) / 2)[..., None]
    return falloff
