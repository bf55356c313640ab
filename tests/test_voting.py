# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The vote of step 8 against the paper's example, a reference written from its text, and its properties."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from edgefusion.perception.voting import vote

# Percent, as printed in the paper.
PAPER_BOXES = [
    {"traffic light": 64.87, "loudspeaker": 23.44, "oscilloscope": 1.94, "digital clock": 0.96,
     "cassette player": 0.74},
    {"loudspeaker": 72.32, "traffic light": 5.04, "switch": 4.05, "face powder": 2.13, "lipstick": 1.99},
    {"traffic light": 71.67, "loudspeaker": 13.30, "spotlight": 1.57, "switch": 1.14, "knee pad": 0.77},
]  # fmt: skip
# As it recomputes: the paper prints 47.12 for the first and leaves out the cassette player.
PAPER_SCORES = {
    "traffic light": 47.193, "loudspeaker": 36.353, "switch": 1.730, "face powder": 0.710, "lipstick": 0.663,
    "oscilloscope": 0.647, "spotlight": 0.523, "digital clock": 0.320, "knee pad": 0.257,
    "cassette player": 0.247,
}  # fmt: skip
LABELS = sorted(PAPER_SCORES)

# Few distinct values, so that ties are common; eighths, so that they are exact.
eighths = st.integers(0, 8).map(lambda n: n / 8)
distinct = st.floats(0, 1, width=32)


def tables(elements=eighths | distinct, min_boxes=1):
    shapes = st.tuples(st.integers(min_boxes, 5), st.integers(1, 9))
    return shapes.flatmap(lambda shape: hnp.arrays(np.float32, shape, elements=elements))


def names(table) -> list[str]:
    return [f"class {i}" for i in range(table.shape[1])]


def paper_table():
    return np.array([[box.get(label, 0) / 100 for label in LABELS] for box in PAPER_BOXES], np.float32)


def reference(table, top_k: int):
    """The paper's sentence, word by word: {class index: score}, the best class, its box."""
    proposals = []
    for row in table.tolist():
        best = sorted(range(len(row)), key=lambda i: (-row[i], i))[:top_k]
        proposals.append({i: Fraction(row[i]) for i in best})
    proposed = set().union(*proposals)
    scores = {i: float(sum(each.get(i, 0) for each in proposals)) / len(proposals) for i in proposed}
    winner = min(scores, key=lambda i: (-scores[i], i))
    box = max(range(len(proposals)), key=lambda b: (proposals[b].get(winner, -1), -b))
    return scores, winner, box


def test_the_papers_example_gives_its_label_its_box_and_its_ten_scores() -> None:
    ballot = vote(paper_table(), LABELS)
    assert ballot.winner.label == "traffic light"
    assert ballot.box_index == 2
    assert {score.label: round(100 * score.score, 3) for score in ballot.ranking} == PAPER_SCORES
    assert [score.label for score in ballot.ranking] == list(PAPER_SCORES)
    assert ballot.margin == pytest.approx((0.6487 + 0.0504 + 0.7167 - 0.2344 - 0.7232 - 0.1330) / 3)
    for box, top in zip(PAPER_BOXES, ballot.top5):
        assert {score.label: round(100 * score.score, 2) for score in top} == box


def test_the_single_best_box_of_the_papers_example_would_be_wrong() -> None:
    best_box = np.unravel_index(paper_table().argmax(), (3, len(LABELS)))
    assert LABELS[best_box[1]] == "loudspeaker"


@given(tables(), st.integers(1, 6))
def test_it_equals_a_reference_written_from_the_papers_text(table, top_k: int) -> None:
    ballot = vote(table, names(table), top_k)
    scores, winner, box = reference(table, top_k)
    assert {score.class_index: score.score for score in ballot.ranking} == scores
    assert (ballot.winner.class_index, ballot.box_index) == (winner, box)


@given(tables(), st.randoms(use_true_random=False))
def test_permuting_the_boxes_permutes_the_box_and_leaves_the_scores(table, random) -> None:
    order = list(range(len(table)))
    random.shuffle(order)
    ballot, permuted = vote(table, names(table)), vote(table[order], names(table))
    assert permuted.ranking == ballot.ranking
    assert permuted.margin == ballot.margin
    assert permuted.top5 == tuple(ballot.top5[box] for box in order)
    given_to_winner = [{s.class_index: s.score for s in top} for top in ballot.top5]
    best = given_to_winner[ballot.box_index][ballot.winner.class_index]
    assert given_to_winner[order[permuted.box_index]][ballot.winner.class_index] == best


@given(tables(elements=distinct))
def test_scores_of_probabilities_sum_to_at_most_one_and_fall(table) -> None:
    table = table / np.maximum(table.sum(axis=1, keepdims=True), 1)
    ballot = vote(table.astype(np.float32), names(table))
    scores = [score.score for score in ballot.ranking]
    assert math.fsum(scores) <= 1 + 1e-6
    assert scores == sorted(scores, reverse=True)
    assert 0 <= ballot.margin <= ballot.winner.score


@given(tables(), st.data())
def test_a_box_without_an_answer_is_dropped_and_the_others_voted(table, data) -> None:
    broken = data.draw(st.lists(st.booleans(), min_size=len(table), max_size=len(table)))
    poison = data.draw(st.sampled_from([np.nan, np.inf, -np.inf]))
    poisoned = table.copy()
    poisoned[broken, data.draw(st.integers(0, table.shape[1] - 1))] = poison
    ballot = vote(poisoned, names(table))
    kept = [box for box, out in enumerate(broken) if not out]
    if not kept:
        assert ballot is None
        return
    others = vote(table[kept], names(table))
    assert ballot.ranking == others.ranking
    assert ballot.box_index == kept[others.box_index]  # still counts the rows that came in
    assert [bool(top) for top in ballot.top5] == [not out for out in broken]


@pytest.mark.parametrize("table", [np.zeros((0, 4)), np.full((3, 4), np.nan), np.full((1, 4), np.inf)])
def test_no_answer_at_all_is_no_vote(table) -> None:
    assert vote(table.astype(np.float32), list("abcd")) is None


def test_classes_of_one_name_are_kept_apart() -> None:
    ballot = vote(np.array([[0.3, 0.3, 0.4]], np.float32), ["crane", "crane", "dam"])
    assert [(score.class_index, score.label) for score in ballot.ranking] == [
        (2, "dam"),
        (0, "crane"),
        (1, "crane"),
    ]


def test_ties_go_to_the_lower_class_and_then_to_the_earlier_box() -> None:
    ballot = vote(np.full((3, 9), 1 / 9, np.float32), list("abcdefghi"))
    assert [score.label for score in ballot.ranking] == list("abcde")
    assert (ballot.winner.label, ballot.box_index, ballot.margin) == ("a", 0, 0.0)


def test_a_class_that_a_box_did_not_propose_counts_nothing_there() -> None:
    # The second box holds 0.16 for class 0, but five others before it.
    table = np.array([[0.2, 0.1, 0, 0, 0, 0.1], [0.16, 0.17, 0.17, 0.17, 0.17, 0.165]], np.float32)
    ballot = vote(table, list("abcdef"))
    scores = {score.label: score.score for score in ballot.ranking}
    assert scores["a"] == pytest.approx(0.1)


def test_a_single_class_has_its_score_as_margin() -> None:
    ballot = vote(np.array([[0.75], [0.25]], np.float32), ["only"])
    assert (ballot.winner.score, ballot.margin, ballot.box_index) == (0.5, 0.5, 0)


@pytest.mark.parametrize(
    ("table", "labels", "message"),
    [
        (np.zeros(3), "abc", r"probabilities: expected shape \[boxes, 3\], got \[3\]"),
        (np.zeros((2, 4)), "abc", r"probabilities: expected shape \[boxes, 3\], got \[2, 4\]"),
        (np.zeros((2, 0)), "", r"probabilities: expected shape \[boxes, 1 or more\], got \[2, 0\]"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(table, labels: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        vote(table.astype(np.float32), list(labels))


def test_a_vote_of_no_classes_per_box_is_refused() -> None:
    with pytest.raises(ValueError, match="top_k: expected at least 1, got 0"):
        vote(np.zeros((1, 2), np.float32), list("ab"), top_k=0)
