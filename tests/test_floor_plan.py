# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The plan at the laser's height is the cut of every surface there, and knows whose each segment is."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.sim.floor_plan import BUILDING, NOTHING_MET, FloorPlan, cut, distances_m, floor_plan
from edgefusion.sim.mesh import Part, box, drum, placed, plain, prism, quad, standing_box

GREY = plain(0x808080)
CUBE = standing_box((1.0, 2.0, 1.0), GREY)


def lengths(segments: np.ndarray) -> np.ndarray:
    return np.asarray(np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]))


def plan_of(*bodies: list[Part], building: list[Part] | None = None, height_m: float = 0.35) -> FloorPlan:
    return floor_plan(building or [], bodies, height_m)


def test_a_box_is_cut_along_its_four_sides() -> None:
    segments = cut(CUBE, 0.35)
    assert lengths(segments).sum() == pytest.approx(6.0)
    ends = segments.reshape(-1, 2)
    np.testing.assert_allclose(np.abs(ends).max(axis=0), (0.5, 1.0), rtol=1e-6)
    on_a_side = np.isclose(np.abs(ends[:, 0]), 0.5) | np.isclose(np.abs(ends[:, 1]), 1.0)
    assert on_a_side.all()


def test_a_drum_is_cut_along_its_circumference() -> None:
    segments = cut(drum(0.3, 0.0, 1.0, GREY, segments=64), 0.35)
    np.testing.assert_allclose(np.hypot(*segments.reshape(-1, 2).T), 0.3, rtol=2e-3)
    assert lengths(segments).sum() == pytest.approx(64 * 2 * 0.3 * math.sin(math.pi / 64), rel=1e-4)


@pytest.mark.parametrize("height_m", [-0.1, 1.1])
def test_a_plane_above_or_below_a_body_misses_it(height_m: float) -> None:
    assert cut(CUBE, height_m).shape == (0, 4)


@pytest.mark.parametrize("height_m", [0.0, 1.0])
def test_a_plane_through_a_level_face_does_not_double_its_edges(height_m: float) -> None:
    assert lengths(cut(CUBE, height_m)).sum() == pytest.approx(6.0) or cut(CUBE, height_m).shape == (0, 4)


def test_nothing_is_cut_of_nothing() -> None:
    assert cut([], 0.35).shape == (0, 4)


ANGLES = st.sets(st.integers(0, 31), min_size=3, max_size=9)
TURNS = st.tuples(*[st.floats(-math.pi, math.pi)] * 3)


def rotation(turns: tuple[float, float, float]) -> np.ndarray:
    return np.asarray(cv2.Rodrigues(np.array(turns))[0])


@settings(max_examples=80)
@given(ANGLES, st.floats(0.3, 2), TURNS, st.floats(0.05, 0.95))
def test_the_cut_of_a_convex_body_is_its_closed_outline(angles, stretch, turns, share) -> None:
    turned = np.array(sorted(angles)) * 2 * math.pi / 32
    outline = np.stack([np.cos(turned), stretch * np.sin(turned)], axis=1)
    body = placed(prism(outline, -0.4, 0.6, GREY), rotation=rotation(turns))
    heights = np.concatenate([part.vertices[:, 2] for part in body]).astype(float)
    segments = cut(body, heights.min() + share * np.ptp(heights))
    ends = segments.reshape(-1, 2)
    apart = np.hypot(*(ends[:, None] - ends).T) + np.eye(len(ends))
    assert apart.min(axis=0).max() < 1e-5  # every end is another one's beginning
    hull = cv2.convexHull(ends.astype(np.float32))
    assert lengths(segments).sum() == pytest.approx(cv2.arcLength(hull, True), rel=1e-3, abs=1e-3)


def test_segments_know_their_owners() -> None:
    wall = [quad([(3, 2, 2), (3, -2, 2), (3, -2, 0), (3, 2, 0)], GREY)]
    near, low, far = placed(CUBE, (0, 0, 0)), standing_box((1, 1, 0.2), GREY), placed(CUBE, (0, 5, 0))
    plan = plan_of(near, low, far, building=wall)
    assert set(plan.owners.tolist()) == {BUILDING, 0, 2}
    np.testing.assert_allclose(plan.of(BUILDING)[:, [0, 2]], 3)
    np.testing.assert_allclose(plan.of(2), cut(far, 0.35))
    assert plan.of(1).shape == (0, 4)
    assert len(plan.segments) == len(plan.owners) == sum(len(plan.of(owner)) for owner in (BUILDING, 0, 1, 2))


def test_a_plan_cannot_be_changed() -> None:
    plan = plan_of(CUBE)
    with pytest.raises(ValueError, match="read-only"):
        plan.segments[0, 0] = 1.0


def test_the_nearest_distance_is_to_the_surface_at_that_height() -> None:
    step = CUBE + box((0.6, 2.0, 0.2), (-0.8, 0, 0.1), GREY)  # its foot sticks out below the plane
    plan = plan_of(placed(step, (3, 0, 0)), standing_box((1, 1, 0.2), GREY))
    assert plan.nearest_m(0, (0, 0)) == pytest.approx(2.5)
    assert plan.nearest_m(0, (2.5 - 3, 1 + 4)) == pytest.approx(5)
    assert plan.nearest_m(1, (0, 0)) == math.inf


def test_the_clearance_is_to_whatever_else_is_nearest() -> None:
    wall = [quad([(3, 4, 2), (3, -4, 2), (3, -4, 0), (3, 4, 0)], GREY)]
    plan = plan_of(CUBE, placed(CUBE, (0, 2.4, 0)), placed(CUBE, (2.45, 0, 0)), building=wall)
    assert plan.clearance_m(0) == pytest.approx(0.4)
    assert plan.clearance_m(1) == pytest.approx(0.4)
    assert plan.clearance_m(2) == pytest.approx(0.05, abs=1e-6)


def test_the_clearance_of_a_body_that_is_alone_or_below_the_plane_is_infinite() -> None:
    assert plan_of(CUBE).clearance_m(0) == math.inf
    assert plan_of(CUBE, standing_box((1, 1, 0.2), GREY)).clearance_m(1) == math.inf


COORDINATE = st.floats(-5, 5)


@given(st.tuples(COORDINATE, COORDINATE), st.tuples(*[COORDINATE] * 4))
def test_the_distance_to_a_segment_is_that_to_its_nearest_point(point, segment) -> None:
    start, end = np.array(segment[:2]), np.array(segment[2:])
    on_it = start + np.linspace(0, 1, 401)[:, None] * (end - start)
    nearest = np.hypot(*(on_it - point).T).min()
    found = distances_m([point], np.array([segment]))[0, 0]
    assert nearest - np.hypot(*(end - start)) / 400 <= found + 1e-9 and found <= nearest + 1e-9


def test_every_beam_has_an_owner_whatever_it_met() -> None:
    plan = FloorPlan(np.zeros((3, 4)), np.array([BUILDING, 0, 1], np.int32))
    assert plan.owners_of(np.array([2, -1, 0, 1], np.int32)).tolist() == [1, NOTHING_MET, BUILDING, 0]
    empty = FloorPlan(np.zeros((0, 4)), np.zeros(0, np.int32))
    assert empty.owners_of(np.full(2, -1, np.int32)).tolist() == [NOTHING_MET] * 2
