# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How near a hull comes to segments: known distances, and no point of a segment nearer than is said."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.sim.hull import Hull, bounded
from edgefusion.types import STILL, Pose2D

BOX = ((0.2, 0.1), (-0.3, 0.1), (-0.3, -0.1), (0.2, -0.1))
number = st.floats(-2, 2, width=32)


def clearance_m(segments, pose=STILL, below_m=math.inf, corners=BOX):
    return Hull(corners).clearance_m(pose, bounded(np.array(segments, float).reshape(-1, 4)), below_m)


@pytest.mark.parametrize(
    ("segment", "expected_m"),
    [
        ((0.5, -1, 0.5, 1), 0.3),  # ahead of the nose
        ((-0.7, -1, -0.7, 1), 0.4),  # behind the tail, which is longer
        ((0.5, 0.5, 0.6, 0.6), 0.5),  # beyond a corner: 3, 4, 5
        ((-1, -0.4, 1, -0.4), 0.3),  # along a side, longer than it
        ((0.1, -1, 0.1, 1), 0.0),  # through the hull
        ((-0.1, 0, 0.1, 0.02), 0.0),  # inside it
        ((0.2, -1, 0.2, 1), 0.0),  # along its nose
        ((0.0, 0.1, 0.0, 2.0), 0.0),  # an end on its side
    ],
)
def test_known_distances(segment, expected_m):
    assert clearance_m(segment) == pytest.approx(expected_m)


def test_the_hull_stands_at_the_pose():
    wall = (-5, 2.0, 5, 2.0)
    assert clearance_m(wall, Pose2D(1, 1, 0)) == pytest.approx(0.9)
    assert clearance_m(wall, Pose2D(1, 1, math.pi / 2)) == pytest.approx(0.8)
    assert clearance_m(wall, Pose2D(1, 1, -math.pi / 2)) == pytest.approx(0.7)
    np.testing.assert_allclose(
        Hull(BOX).at(Pose2D(1, 2, math.pi / 2)), [[0.9, 2.2], [0.9, 1.7], [1.1, 1.7], [1.1, 2.2]]
    )


def test_what_is_not_nearer_than_the_limit_is_nowhere():
    assert clearance_m((0.5, -1, 0.5, 1), below_m=0.29) == math.inf
    assert clearance_m((0.5, -1, 0.5, 1), below_m=0.31) == pytest.approx(0.3)
    assert clearance_m([]) == math.inf


def test_corners_in_either_direction_are_the_same_hull():
    segment = (0.4, 0.3, 0.9, 0.2)
    assert clearance_m(segment, corners=BOX[::-1]) == clearance_m(segment)


@given(st.tuples(number, number, number, number), st.tuples(number, number, st.floats(-3.2, 3.2)))
def test_the_distance_is_that_of_the_nearest_two_points(segment, pose):
    pose = Pose2D(*pose)
    shares = np.linspace(0, 1, 201)[:, None]
    points = np.array(segment[:2]) + shares * (np.array(segment[2:]) - segment[:2])
    seen = np.array([Pose2D(*point).relative_to(pose) for point in points.tolist()])
    local = np.array([(p.x_m, p.y_m) for p in seen])
    beyond = np.maximum(np.maximum(local - (0.2, 0.1), (-0.3, -0.1) - local), 0)
    nearest_m, apart_m = np.hypot(*beyond.T).min(), math.hypot(*(points[-1] - points[0])) / 200
    assert nearest_m - apart_m / 2 - 1e-9 <= clearance_m(segment, pose) <= nearest_m + 1e-9


@given(st.lists(st.tuples(number, number, number, number), min_size=1, max_size=8), st.floats(0.01, 3))
def test_of_many_segments_the_nearest_counts_with_any_limit(segments, below_m):
    nearest_m = min(clearance_m(segment) for segment in segments)
    expected_m = nearest_m if nearest_m < below_m else math.inf
    assert clearance_m(segments, below_m=below_m) == pytest.approx(expected_m)


@pytest.mark.parametrize("corners", [BOX[:2], ((0, 0), (1, 0), (0.2, 0.2), (0, 1)), ((0, 0), (1, 0), (2, 0))])
def test_what_is_no_convex_outline_is_refused(corners):
    with pytest.raises(RefusedError, match="hull: expected"):
        Hull(corners)
