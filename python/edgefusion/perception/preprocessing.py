# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From boxes of an image to the batch that a classifier takes."""

import math
from typing import Literal, Optional, Sequence, Tuple, Union, get_args

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion import _core
from edgefusion.errors import RefusedError

Fit = Literal["squash", "letterbox", "square-context", "shorter-side+centre"]
"""How a box of any shape becomes a square; see `_core.crops`."""

Filter = Literal["antialias", "linear"]
"""How pixels are resized: as Pillow's BILINEAR does, or as OpenCV's INTER_LINEAR does."""

Boxes = Union[npt.NDArray[np.int32], Sequence[Sequence[int]]]
Triple = Tuple[float, float, float]

LARGEST = 4096
"""Pixels a side of a network's input; a float32 picture of it takes 200 MB."""

IMAGENET_MEAN: Triple = (0.485, 0.456, 0.406)
IMAGENET_STD: Triple = (0.229, 0.224, 0.225)


class Preprocessing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What turns a box of an image into one input of the network. All of it is the model's, none the user's.

    size: side of the square, pixels. mean, std: RGB, of values 0..1. crop_fraction: what is kept of the
    shorter side, for the fit "shorter-side+centre" only (torchvision's 224 of 256 is 0.875).

    Raises RefusedError for a value that cannot be.
    """

    size: int
    fit: Fit
    filter: Filter
    mean: Triple
    std: Triple
    crop_fraction: float

    def __post_init__(self) -> None:
        fits, filters = get_args(Fit), get_args(Filter)
        _expect(1 <= self.size <= LARGEST, "size", f"1 to {LARGEST} pixels", self.size)
        _expect(self.fit in fits, "fit", f"one of {', '.join(fits)}", self.fit)
        _expect(self.filter in filters, "filter", f"one of {', '.join(filters)}", self.filter)
        _expect(_is_triple(self.mean), "mean", "three numbers", self.mean)
        _expect(_is_triple(self.std) and min(self.std) > 0, "std", "three numbers above 0", self.std)
        _expect(0 < self.crop_fraction <= 1, "crop_fraction", "above 0 and at most 1", self.crop_fraction)
        if self.fit != "shorter-side+centre":
            _expect(self.crop_fraction == 1, "crop_fraction", f"1 with fit {self.fit}", self.crop_fraction)

    def apply(
        self, image: npt.NDArray[np.uint8], boxes: Boxes, out: Optional[npt.NDArray[np.float32]] = None
    ) -> npt.NDArray[np.float32]:
        """Boxes [n, 4] of a BGR image as float32[n, 3, size, size], written into `out` where one is given.

        Raises ValueError for a box that is empty or not inside the image.
        """
        return _core.crops(image, boxes, self.size, self.mean, self.std, self.fit, self.filter, self.crop_fraction, out)


def whole(image: npt.NDArray[np.uint8]) -> Boxes:
    """The box [1, 4] that is the whole image."""
    return np.array([[0, 0, image.shape[1], image.shape[0]]], np.int32)


def _is_triple(values: Sequence[float]) -> bool:
    return len(values) == 3 and all(math.isfinite(value) for value in values)


def _expect(holds: bool, name: str, expected: str, came: object) -> None:
    if not holds:
        raise RefusedError(f"{name}: expected {expected}, got {came}")


PAPER = Preprocessing(
    size=256, fit="squash", filter="antialias", mean=IMAGENET_MEAN, std=IMAGENET_STD, crop_fraction=1.0
)
"""The paper's: every box squashed to 256 x 256, normalized as for ImageNet."""

DEFAULT = Preprocessing(
    size=256, fit="letterbox", filter="antialias", mean=IMAGENET_MEAN, std=IMAGENET_STD, crop_fraction=1.0
)
"""What a model gets of which nothing else is known: squashing changes the shape of what is to be named, which
costs one object in twelve its group (BENCHMARKS.md)."""
