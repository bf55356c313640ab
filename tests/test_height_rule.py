# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The two height rules: the paper's, and the weighted mean between the candidates."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.perception.height_rule import HEIGHT_RULES, choose_box
from edgefusion.perception.voting import vote

BOXES = [
    (10, 60, 50, 100),
    (10, 40, 50, 100),
    (10, 20, 50, 100),
]  # of one bottom edge, as the detector makes them
LABELS = ["lamp", "chair"]


def table(*winner: float):
    return np.array([[p, 0.01] for p in winner], np.float32)


def chosen(rule: str, rows, boxes=BOXES):
    return choose_box(rule, vote(rows, LABELS), boxes, rows)


@st.composite
def candidates(draw):
    count = draw(st.integers(1, 4))
    edges = st.lists(st.integers(0, 2000), min_size=2, max_size=2, unique=True).map(sorted)
    boxes = []
    for _ in range(count):
        (x0, x1), (y0, y1) = draw(edges), draw(edges)
        boxes.append((x0, y0, x1, y1))
    share = st.floats(0, 1, width=32)
    rows = draw(st.lists(st.tuples(share, share), min_size=count, max_size=count))
    return np.array(boxes), np.array(rows, np.float32)


def test_the_papers_rule_takes_the_box_that_gave_the_winner_its_highest_probability() -> None:
    assert chosen("paper", table(0.2, 0.7, 0.5)) == BOXES[1]


def test_the_weighted_rule_puts_the_top_edge_between_the_candidates() -> None:
    assert chosen("weighted", table(0.25, 0.5, 0.25)) == (10, 40, 50, 100)
    assert chosen("weighted", table(0.5, 0.5, 0.0)) == (10, 50, 50, 100)
    assert chosen("weighted", table(0.75, 0.0, 0.25)) == (10, 50, 50, 100)


def test_the_sharpened_rule_lies_near_the_surest_boxes_and_between_two_that_are_as_sure() -> None:
    assert chosen("sharpened", table(0.25, 0.5, 0.25))[1] == chosen("paper", table(0.25, 0.5, 0.25))[1]
    assert chosen("sharpened", table(0.5, 0.5, 0.1)) == (10, 50, 50, 100)
    # Weights 0.9**8 and 0.8**8: 0.43 and 0.168, so that the edge is at 60 - 20 * 0.281.
    assert chosen("sharpened", table(0.9, 0.8, 0.0)) == (10, 54, 50, 100)


@given(candidates())
def test_the_weighted_rule_is_the_exact_mean_to_half_a_pixel(drawn) -> None:
    boxes, rows = drawn
    ballot = vote(rows, LABELS)
    weights = [Fraction(float(p)) for p in rows[:, ballot.winner.class_index]]
    assume(sum(weights) >= Fraction(1, 100))  # far below, the weights' own rounding shows
    box = choose_box("weighted", ballot, boxes, rows)
    for edge, column in zip(box, boxes.T.tolist()):
        mean = sum(w * c for w, c in zip(weights, column)) / sum(weights)
        assert abs(edge - mean) <= Fraction(1, 2) + Fraction(1, 40)


@given(candidates(), st.sampled_from(HEIGHT_RULES))
def test_no_rule_leaves_the_hull_of_the_candidates_or_gives_an_empty_box(drawn, rule: str) -> None:
    boxes, rows = drawn
    x0, y0, x1, y1 = choose_box(rule, vote(rows, LABELS), boxes, rows)
    assert boxes[:, 0].min() <= x0 < x1 <= boxes[:, 2].max()
    assert boxes[:, 1].min() <= y0 < y1 <= boxes[:, 3].max()


@given(candidates(), st.sampled_from(HEIGHT_RULES))
def test_an_edge_that_all_candidates_share_is_kept(drawn, rule: str) -> None:
    boxes, rows = drawn
    boxes[:, 3] = 2001
    assert choose_box(rule, vote(rows, LABELS), boxes, rows)[3] == 2001


@pytest.mark.parametrize("rule", HEIGHT_RULES)
def test_a_box_that_was_left_out_of_the_vote_has_no_say(rule: str) -> None:
    assert chosen(rule, table(0.5, np.nan, 0.0)) == BOXES[0]
    assert chosen(rule, table(np.inf, 0.5, 0.0)) == BOXES[1]


def test_without_any_probability_the_weighted_rule_is_the_papers() -> None:
    rows = np.zeros((3, 2), np.float32)
    assert chosen("weighted", rows) == chosen("paper", rows) == BOXES[0]


def test_the_box_is_of_plain_integers() -> None:
    for rule in HEIGHT_RULES:
        box = chosen(rule, table(0.2, 0.7, 0.5))
        assert isinstance(box, tuple)
        assert [type(edge) for edge in box] == [int] * 4


def test_an_unknown_rule_is_refused() -> None:
    with pytest.raises(RefusedError, match="height rule: expected one of paper, weighted, sharpened, got 'tallest'"):
        chosen("tallest", table(0.2, 0.7, 0.5))


def test_boxes_or_probabilities_that_are_not_those_of_the_vote_are_refused() -> None:
    rows = table(0.2, 0.7, 0.5)
    with pytest.raises(ValueError, match=r"boxes: expected shape \[3, 4\], got \[2, 4\]"):
        choose_box("paper", vote(rows, LABELS), BOXES[:2], rows)
    with pytest.raises(ValueError, match=r"class_probabilities: expected shape \[3, classes\], got \[2, 2\]"):
        choose_box("weighted", vote(rows, LABELS), BOXES, rows[:2])
