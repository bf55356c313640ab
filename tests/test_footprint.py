# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The hull of a base: its circles, and how far it is from a point."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from edgefusion._core import Footprint
from navigation_scenes import P3DX, distance, lines_gap

HERE = (0.0, 0.0, 0.0)
COORDINATES = st.floats(-3, 3)


@st.composite
def hulls(draw):
    """Corners on an ellipse about the origin, no two neighbours half a turn apart: convex, and the origin is inside."""
    thirds = sorted(draw(st.sets(st.integers(0, 119), min_size=3, max_size=9)))
    assume(all((b - a) % 120 < 58 for a, b in zip(thirds, [*thirds[1:], thirds[0]])))
    a, b = draw(st.floats(0.05, 2)), draw(st.floats(0.05, 2))
    corners = np.array([[a * math.cos(d * math.pi / 60), b * math.sin(d * math.pi / 60)] for d in thirds])
    return corners if draw(st.booleans()) else corners[::-1]


def test_the_circles_of_a_pioneer_are_known() -> None:
    hull = Footprint(P3DX)
    assert hull.inscribed_m == pytest.approx(0.210)
    assert hull.circumscribed_m == pytest.approx(math.hypot(0.301, 0.2125))


def test_the_gap_to_a_side_is_exact_and_below_0_inside() -> None:
    hull = Footprint(P3DX)
    assert hull.gap(0.310, 0.1) == pytest.approx(0.1)
    assert hull.gap(-0.401, -0.2) == pytest.approx(0.1)
    assert hull.gap(0.0, 0.2) == pytest.approx(-0.0125)
    assert hull.gap(0.210, 0.0) == pytest.approx(0.0, abs=1e-15)


@given(hulls(), COORDINATES, COORDINATES)
def test_the_gap_is_exact_inside_and_never_more_than_the_distance_outside(corners, x: float, y: float) -> None:
    gap, true = Footprint(corners).gap(x, y), distance(corners, HERE, [[x, y]])[0, 0]
    assert gap == pytest.approx(lines_gap(corners, HERE, [[x, y]])[0, 0], abs=1e-12)
    assert gap <= true + 1e-12
    if gap < -1e-9:
        assert gap == pytest.approx(true, abs=1e-9)


@given(hulls(), st.floats(0, 7))
def test_the_inscribed_circle_is_inside_and_the_hull_inside_the_circumscribed_one(corners, angle: float) -> None:
    hull, x, y = Footprint(corners), math.cos(angle), math.sin(angle)
    assert hull.gap(hull.inscribed_m * x, hull.inscribed_m * y) <= 1e-12
    assert hull.gap(1.001 * hull.circumscribed_m * x, 1.001 * hull.circumscribed_m * y) > 0
    assert hull.circumscribed_m == pytest.approx(np.hypot(*corners.T).max())
    assert -hull.inscribed_m == pytest.approx(hull.gap(0, 0))


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ([[1, 0], [0, 1]], "footprint: expected at least 3 corners, got 2"),
        (np.zeros((0, 2)), "footprint: expected at least 3 corners, got 0"),
        ([[1, 0, 0]] * 3, r"footprint: expected shape \[n, 2\], got \[3, 3\]"),
        ([[1, 0], [0, 1], [-1, math.nan]], "footprint: expected finite numbers, got nan at index 5"),
        ([[1, 0], [1, 0], [-1, 1], [-1, -1]], "footprint: corner 0 and the next are the same"),
        (
            [[1, 1], [0.1, 0], [1, -1], [-1, -1], [-1, 1]],
            "footprint: expected a convex polygon, got one with corner .*",
        ),
        ([[1, -1], [3, -1], [3, 1], [1, 1]], "footprint: expected the origin, the middle of the axle, inside"),
        ([[0, -1], [3, -1], [3, 1], [0, 1]], "footprint: expected the origin, the middle of the axle, inside"),
        ([[1, 0], [2, 0], [-1, 0]], "footprint: expected .*"),
    ],
)
def test_what_is_no_hull_is_refused_by_name(corners, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        Footprint(corners)
