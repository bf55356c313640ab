# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The golden answer: a picture in the model folder, and what the network said to it when the folder was made.

It goes the whole way, from the picture's pixels through the preprocessing to the probabilities, so that a
model, a setting or a runtime that answers differently is noticed before the robot moves.
"""

from dataclasses import dataclass
from typing import List, Mapping, Sequence

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.perception.onnx_header import Precision

TOLERANCES: Mapping[Precision, float] = {"fp32": 1e-3, "fp16": 2e-2, "int8": 2e-2}
"""By how much a probability may differ between two runtimes."""

TELLS_ENOUGH = 0.1
"""Of `telling`: the search for a picture ends there."""

SEEDS = range(32)

_TOP = 5
_SHAPES = 60


class GoldenAnswer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The best classes, best first, and their probabilities."""

    classes: List[int]
    probabilities: List[float]

    def __post_init__(self) -> None:
        if not self.classes or len(self.classes) != len(self.probabilities):
            raise ValueError(
                f"golden: expected as many classes as probabilities, at least 1, "
                f"got {len(self.classes)} and {len(self.probabilities)}"
            )
        for probability in self.probabilities:
            if not 0 <= probability <= 1:
                raise ValueError(f"golden: expected probabilities of 0..1, got {probability:g}")


@dataclass(frozen=True)
class Golden:
    """picture: BGR uint8 [height, width, 3]. tolerance: on each of the answer's probabilities."""

    picture: npt.NDArray[np.uint8]
    answer: GoldenAnswer
    tolerance: float

    def compare(self, got: npt.NDArray[np.float32], labels: Sequence[str]) -> float:
        """The largest difference of a probability. Raises ValueError, one line, for another answer."""
        expected, wanted = self.answer.classes[0], self.answer.probabilities
        if not np.isfinite(got).all():
            raise ValueError(f"expected the golden answer {labels[expected]}, got numbers that are not finite")
        first = int(got.argmax())
        if first != expected:
            came = f"{labels[first]} ({got[first]:.4f})"
            raise ValueError(f"expected the golden answer {labels[expected]} ({wanted[0]:.4f}), got {came}")
        difference = float(np.abs(got[self.answer.classes] - np.asarray(wanted)).max())
        if difference > self.tolerance:
            within = f"expected the golden probabilities within {self.tolerance:g}"
            raise ValueError(f"{within}, got a difference of {difference:.4g}")
        return difference


def answer_of(probabilities: npt.NDArray[np.float32]) -> GoldenAnswer:
    """The answer to write down, of one row of probabilities."""
    best = np.argsort(-probabilities, kind="stable")[:_TOP]
    # Rounding takes off what float32 may leave above 1; adding 0 makes -0 a 0.
    return GoldenAnswer([int(i) for i in best], [round(float(probabilities[i]), 6) + 0.0 for i in best])


def lead_of(answer: GoldenAnswer) -> float:
    """How far the first class is ahead of the second; of a single class, all the way."""
    best = answer.probabilities
    return best[0] - best[1] if len(best) > 1 else best[0]


def least_lead(tolerance: float) -> float:
    """With less, the first class could differ between two runtimes that are both within the tolerance."""
    return 2 * tolerance


def telling(answer: GoldenAnswer, tolerance: float) -> float:
    """How much an answer says, up to 0.5: a doubtful one may turn over, a certain one hardly ever changes."""
    lead = lead_of(answer)
    return min(lead, 1 - answer.probabilities[0]) if lead > least_lead(tolerance) else -1 + lead


def golden_picture(seed: int, size: int) -> npt.NDArray[np.uint8]:
    """A made-up picture, BGR, 1.5 * size high and 2 * size wide, the same for the same seed.

    Larger than the network's input and not square, with flat colours, edges, and stripes as fine as a pixel:
    the fit, the filter and the order of the colours all change the answer.
    """
    rng = np.random.default_rng(seed)
    height, width = max(3 * size // 2, 8), max(2 * size, 8)
    picture = np.empty((height, width, 3), np.uint8)
    picture[:] = rng.integers(0, 256, 3)
    for _ in range(_SHAPES):
        y, x = rng.integers(0, height), rng.integers(0, width)
        patch = picture[y : y + rng.integers(2, height // 2), x : x + rng.integers(2, width // 2)]
        patch[:: rng.integers(1, 4), :: rng.integers(1, 4)] = rng.integers(0, 256, 3)
    return picture
