# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a kind of object is: a name, the label that is its truth, its usual size, and how to build one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Tuple

import numpy as np

from edgefusion.sim.mesh import Part, scaled, size_of

Size = Tuple[float, float, float]
"""(depth, width, height) along x, y, z [m], with whatever the object stands on."""


@dataclass(frozen=True)
class Kind:
    """A kind of object.

    label: ImageNet's label, or UNKNOWN for an obstacle without a name. size_m: the usual size. build: the parts of
    one object of about that size, its colours, proportions and details drawn from the generator.

    A support (the trolley under an oscilloscope) belongs to the object: to its mask, its box, its nearest range.
    """

    name: str
    label: str
    size_m: Size
    build: Callable[[np.random.Generator], list[Part]]

    def make(self, seed: int, size_m: Size | None = None) -> list[Part]:
        """The parts of one object; the same seed gives the same. size_m: exactly so large, else as it is built."""
        parts = self.build(np.random.default_rng(seed))
        if size_m is None:
            return parts
        return scaled(parts, [wanted / found for wanted, found in zip(size_m, size_of(parts))])
