# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which box an object gets, of candidates that differ in height: the laser sees its width only."""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Box, Vote

HEIGHT_RULES = ("paper", "weighted", "sharpened")
"""`paper`: the box that proposed the winner with the highest probability (step 8). `weighted`: the mean of all
boxes, each weighted by the winner's probability in it, for an object whose height lies between candidates.
`sharpened`: the same by the eighth power of that, for a network that is taught to doubt boxes that do not fit."""

_SHARPNESS = 8

_WEIGHT_UNIT = 1 << 24  # float32's resolution: weights as integers, so that the mean is exact


def choose_box(
    rule: str,
    vote: Vote,
    boxes: Sequence[Box] | npt.NDArray[np.integer[Any]],
    class_probabilities: npt.NDArray[np.float32],
) -> Box:
    """The box of an object.

    Parameters
    ----------
    rule : one of HEIGHT_RULES
    vote : the vote over these boxes
    boxes : int[boxes, 4], the candidates in pixels
    class_probabilities : float32[boxes, classes], what was voted on

    Returns
    -------
    The box; never outside the hull of the candidates and never empty unless one of them is.

    Raises
    ------
    RefusedError
        The rule is unknown.
    ValueError
        The shapes do not fit the vote.
    """
    candidates = np.asarray(boxes, np.int64)
    if candidates.shape != (len(vote.top5), 4):
        raise ValueError(f"boxes: expected shape [{len(vote.top5)}, 4], got {list(candidates.shape)}")
    if class_probabilities.ndim != 2 or len(class_probabilities) != len(candidates):
        raise ValueError(
            f"class_probabilities: expected shape [{len(candidates)}, classes], got {list(class_probabilities.shape)}"
        )
    if rule == "paper":
        return _box(candidates[vote.box_index])
    if rule == "weighted":
        return _weighted(vote, candidates, class_probabilities, 1)
    if rule == "sharpened":
        return _weighted(vote, candidates, class_probabilities, _SHARPNESS)
    raise RefusedError(f"height rule: expected one of {', '.join(HEIGHT_RULES)}, got {rule!r}")


def _weighted(
    vote: Vote, candidates: npt.NDArray[np.int64], class_probabilities: npt.NDArray[np.float32], power: int
) -> Box:
    voted = np.array([len(top) > 0 for top in vote.top5])
    probability = np.where(voted, class_probabilities[:, vote.winner.class_index], 0.0)
    if power > 1:  # relative to the best, or small ones would vanish
        probability = (probability / max(float(probability.max()), 1e-12)) ** power
    weights = np.rint(probability * _WEIGHT_UNIT).astype(np.int64)
    total = int(weights.sum())
    if total == 0:  # no box gives the winner a probability worth the name
        return _box(candidates[vote.box_index])
    # Rounded half up in integers: edges a pixel or more apart stay so, and an edge that all share is kept.
    return _box((2 * (weights @ candidates) + total) // (2 * total))


def _box(edges: npt.NDArray[np.int64]) -> Box:
    x0, y0, x1, y1 = edges.tolist()
    return x0, y0, x1, y1
