# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The hull that a base is said to have: one that the core can drive with, or a refusal in one line."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import Footprint
from edgefusion.config import BaseConfig
from edgefusion.config.outline import LEAST_M
from edgefusion.errors import RefusedError

SQUARE = ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2))
COORDINATES = st.floats(-0.5, 0.5)
CORNERS = st.lists(st.tuples(COORDINATES, COORDINATES), min_size=3, max_size=6).map(tuple)


@pytest.mark.parametrize(
    ("corners", "said"),
    [
        (
            ((1.0, 0.1), (0.5, 0.1), (0.5, -0.1)),
            r"expected the middle of the axle, \(0, 0\), at least 0.05 m inside .*",
        ),
        (tuple((x / 10, y / 10) for x, y in SQUARE), "expected the middle .*, got 0.02 m for the one from .*"),
        (((0.2, 0.0), (-0.2, 0.0), (0.1, 0.0)), "expected .*"),
        ((*SQUARE, SQUARE[-1]), r"expected corners apart from each other, got \(0.2, -0.2\) twice in a row"),
        ((*SQUARE, (0.1, 0.0)), r"expected a convex outline, got .* beyond the side from .*"),
        ((SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]), "expected a convex outline, .*"),
        (SQUARE[:2], ".*length >= 3"),
        (((math.nan, 0.2), *SQUARE[1:]), ".*"),
    ],
)
def test_a_hull_that_no_base_has_is_refused_by_name_in_one_line(corners, said) -> None:
    with pytest.raises(RefusedError, match=f"^footprint_m: {said}$"):
        BaseConfig(footprint_m=corners)


def test_either_way_around_will_do() -> None:
    assert BaseConfig(footprint_m=SQUARE[::-1]).footprint_m == SQUARE[::-1]
    assert BaseConfig(footprint_m=SQUARE).footprint_m == SQUARE


@given(CORNERS)
def test_whatever_is_accepted_the_core_accepts_too(corners) -> None:
    try:
        BaseConfig(footprint_m=corners)
    except RefusedError:
        return
    assert Footprint(corners).inscribed_m >= LEAST_M - 1e-9


@given(st.lists(st.floats(0, 6.2), min_size=3, max_size=8, unique_by=lambda angle: round(angle, 2)))
def test_what_the_core_accepts_and_is_large_enough_is_accepted(angles) -> None:
    corners = tuple((0.4 * math.cos(angle), 0.4 * math.sin(angle)) for angle in sorted(angles))
    try:
        large = Footprint(corners).inscribed_m >= LEAST_M
    except ValueError:
        large = False
    if large:
        assert BaseConfig(footprint_m=corners).footprint_m == corners
