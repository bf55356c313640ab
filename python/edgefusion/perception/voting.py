# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Step 8 of the paper: the candidate boxes of one object vote on its label.

A single box that is too low or too high may be confidently wrong (in the paper's example the best single box
says loudspeaker for a traffic light); a class that several boxes propose is worth more.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
import numpy.typing as npt

from edgefusion.types import ClassScore, Vote


def vote(probabilities: npt.NDArray[np.float32], labels: Sequence[str], top_k: int = 5) -> Vote | None:
    """The label of an object, from the classifier's answers for its candidate boxes.

    The top k classes of each box go into a map class -> score, where score = sum of that class's
    probabilities / number of boxes, and a box that did not propose the class counts 0. The best score is the
    label; the box that proposed it with the highest probability is the object's box. Classes are told apart by
    index, never by name (ImageNet has `crane` and `maillot` twice). Ties go to the lower class index, then to
    the earlier box.

    Parameters
    ----------
    probabilities : float32[boxes, classes]
    labels : the name of each class
    top_k : how many classes a box proposes; all of them where there are fewer

    Returns
    -------
    The vote, or None where no box has an answer, so that the caller drops the object. A box with a non-finite
    probability is left out: it does not count as a box and its `top5` is empty, so that `top5` and `box_index`
    stay aligned with the rows of `probabilities`. The margin equals the score where there is no second class.

    Raises
    ------
    ValueError
        The shapes do not fit, or top_k is below 1.

    Source: the paper, perception, step 8.
    """
    if probabilities.ndim != 2 or probabilities.shape[1] != len(labels) or not labels:
        raise ValueError(
            f"probabilities: expected shape [boxes, {len(labels) or '1 or more'}], got {list(probabilities.shape)}"
        )
    if top_k < 1:
        raise ValueError(f"top_k: expected at least 1, got {top_k}")
    voters = np.flatnonzero(np.isfinite(probabilities).all(axis=1))
    if not len(voters):
        return None
    top5 = _proposals(probabilities, voters, labels, top_k)
    ranking = _ranking(top5, labels, boxes=len(voters))
    winner = ranking[0]
    return Vote(
        ranking=ranking,
        box_index=_best_box(top5, winner.class_index),
        margin=winner.score - (ranking[1].score if len(ranking) > 1 else 0.0),
        top5=top5,
    )


def _proposals(
    probabilities: npt.NDArray[np.float32], voters: npt.NDArray[np.intp], labels: Sequence[str], top_k: int
) -> tuple[tuple[ClassScore, ...], ...]:
    """The k most probable classes of each box, best first, the lower index first among equals."""
    voting = probabilities[voters]
    last = max(len(labels) - top_k, 0)
    # Not argpartition: among classes that tie for the last place it picks any.
    chosen = np.flatnonzero(voting >= np.partition(voting, last, axis=1)[:, last, None])
    rows, classes = np.divmod(chosen, len(labels))
    candidates = sorted(zip(voters[rows].tolist(), (-voting.ravel()[chosen]).tolist(), classes.tolist()))
    top: list[list[ClassScore]] = [[] for _ in probabilities]
    for box, negative, class_index in candidates:
        if len(top[box]) < top_k:
            top[box].append(ClassScore(class_index, labels[class_index], -negative))
    return tuple(map(tuple, top))


def _ranking(top5: Sequence[Sequence[ClassScore]], labels: Sequence[str], boxes: int) -> tuple[ClassScore, ...]:
    """Every proposed class with its mean over the boxes, best first."""
    given: dict[int, list[float]] = {}
    for proposals in top5:
        for proposal in proposals:
            given.setdefault(proposal.class_index, []).append(proposal.score)
    # fsum rounds once, so that the order of the boxes cannot break or make a tie.
    scores = sorted((-math.fsum(each) / boxes, i) for i, each in given.items())
    return tuple(ClassScore(i, labels[i], -negative) for negative, i in scores)


def _best_box(top5: Sequence[Sequence[ClassScore]], class_index: int) -> int:
    """The earliest of the boxes that proposed the class with the highest probability."""
    proposals = [(p.score, -box) for box, top in enumerate(top5) for p in top if p.class_index == class_index]
    return -max(proposals)[1]
