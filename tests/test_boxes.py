# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Candidate boxes of a cluster, against a plain NumPy reference and for any geometry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import VISIBLE, Camera, candidate_boxes, project

WIDTH, HEIGHT = 640, 480
K = np.array([[460, 0, 319.5], [0, 470, 239.5], [0, 0, 1]], float)
T_CAMERA_LASER = np.array([[0, -1, 0, 0.02], [0, 0, -1, 0.2], [1, 0, 0, -0.05], [0, 0, 0, 1]], float)
STEP = np.radians(0.5)
TO_GROUND = [0, 0, -0.25]


def boxes_of(ranges, angles, heights=(0.6, 1.0, 1.6), T=T_CAMERA_LASER, **rule):
    camera = Camera(K, [-0.1, 0.02, 0.001, -0.001, 0.0])
    return candidate_boxes(ranges, angles, STEP, camera, T, TO_GROUND, WIDTH, HEIGHT, heights, **rule)


def test_a_box_spans_exactly_the_beams_each_half_a_step_wider() -> None:
    rng = np.random.default_rng(3)
    angles = STEP * np.arange(-12, 9)
    ranges = 2.5 + rng.normal(0, 0.05, len(angles))
    edges = np.concatenate([angles - STEP / 2, angles + STEP / 2])
    both = np.tile(ranges, 2)
    points = np.stack([both * np.cos(edges), both * np.sin(edges), 0 * both], axis=1)
    pixels, _ = project(points, K, [-0.1, 0.02, 0.001, -0.001, 0.0], T_CAMERA_LASER)
    boxes, indices = boxes_of(ranges, angles, heights=[1.0])
    assert indices.tolist() == [0]
    # Pixel i reaches from i - 0.5 to i + 0.5 in OpenCV's coordinates.
    assert boxes[0, 0] == round(pixels[:, 0].min() + 0.5)
    assert boxes[0, 2] == round(pixels[:, 0].max() + 0.5)


def test_the_indices_say_which_heights_survived() -> None:
    angles = STEP * np.arange(-5, 6)
    # 30 m high: hardly any of that box is in the image.
    _, indices = boxes_of(np.full(11, 2.0), angles, heights=[0.3, 30.0, 0.5], heights_are_metric=True)
    assert indices.tolist() == [0, 2]


def test_a_robot_that_moved_towards_the_object_sees_a_larger_box() -> None:
    angles, ranges = STEP * np.arange(-5, 6), np.full(11, 2.0)
    moved = T_CAMERA_LASER.copy()
    moved[2, 3] -= 0.5
    (far, _), (near, _) = boxes_of(ranges, angles), boxes_of(ranges, angles, T=moved)
    assert (near[:, 2] - near[:, 0] > far[:, 2] - far[:, 0]).all()
    assert (near[:, 3] > far[:, 3]).all()


@st.composite
def faces(draw: st.DrawFn) -> list[tuple[float, float]]:
    """The beams of one thing, most often in view."""
    first, beams = draw(st.floats(-0.5, 0.5)), draw(st.integers(1, 20))
    nearest = draw(st.floats(1, 20))  # nearer, the scan line is below the picture
    return [(first + i * STEP, nearest + draw(st.floats(0, 0.3))) for i in range(beams)]


anywhere = st.lists(
    st.tuples(st.floats(-3.2, 3.2), st.one_of(st.floats(1e-6, 50), st.sampled_from([1e-300, 1e12, 1e300]))),
    max_size=40,
)
positive = st.one_of(st.floats(1e-3, 100), st.sampled_from([1e-300, 1e300]))
shares = st.floats(0, 1, exclude_min=True)


@given(faces(), st.floats(0.5, 2), st.booleans())
def test_a_thing_in_view_has_a_box(beams, height: float, metric: bool) -> None:
    angles, ranges = np.array(beams).T
    boxes, _ = boxes_of(ranges, angles, [height], heights_are_metric=metric, on_ground=False, min_visible=1e-3)
    assert len(boxes) == 1


@given(
    st.one_of(faces(), faces(), anywhere),
    st.lists(positive, min_size=1, max_size=4),
    st.booleans(),
    st.booleans(),
    st.one_of(st.floats(0, 3), st.just(1e308)),
    shares,
)
def test_geometry_never_raises_and_boxes_lie_inside_the_image(
    beams, heights, metric, on_ground, width_step, min_visible
) -> None:
    angles = np.array([angle for angle, _ in beams], float)
    ranges = np.array([range_m for _, range_m in beams], float)
    boxes, indices = boxes_of(
        ranges,
        angles,
        heights,
        heights_are_metric=metric,
        on_ground=on_ground,
        width_step=width_step,
        min_visible=min_visible,
    )
    assert len(boxes) == len(indices) <= len(heights)
    x0, y0, x1, y1 = boxes.T
    assert ((0 <= x0) & (x0 < x1) & (x1 <= WIDTH)).all()
    assert ((0 <= y0) & (y0 < y1) & (y1 <= HEIGHT)).all()


def test_beams_that_the_camera_does_not_see_add_nothing() -> None:
    angles = STEP * np.arange(-5, 6)
    seen, _ = boxes_of(np.full(11, 2.0), angles)
    behind = np.append(angles, np.pi)
    points = np.array([[-2.0, 0.0, 0.0]])
    assert project(points, K, [], T_CAMERA_LASER)[1][0] != VISIBLE
    with_behind, _ = boxes_of(np.full(12, 2.0), behind)
    np.testing.assert_array_equal(seen, with_behind)


GOOD = {
    "ranges_m": [2.0, 2.0],
    "angles_rad": [0.0, STEP],
    "step_rad": STEP,
    "camera": Camera(K),
    "T_camera_laser": T_CAMERA_LASER,
    "to_ground": TO_GROUND,
    "width": WIDTH,
    "height": HEIGHT,
    "heights": [1.0],
}


def test_ranges_may_be_single_precision_and_everything_an_array() -> None:
    arrays = {"ranges_m": np.float32([2, 2]), "heights": np.array([1]), "to_ground": np.float32(TO_GROUND)}
    np.testing.assert_array_equal(candidate_boxes(**{**GOOD, **arrays})[0], candidate_boxes(**GOOD)[0])


@pytest.mark.parametrize(
    ("argument", "value", "message"),
    [
        ("ranges_m", [2.0, np.nan], "expected finite numbers, got nan at index 1"),
        ("ranges_m", np.float32([np.inf, 2.0]), "expected finite numbers, got inf at index 0"),
        ("ranges_m", ["2", "2"], "expected real numbers, got <U1"),
        ("angles_rad", [-np.inf, 0.0], "expected finite numbers, got -inf at index 0"),
        ("angles_rad", [0.0], r"expected shape \[2\], got \[1\]"),
        ("step_rad", 0.0, "expected a finite number above 0, got 0"),
        ("step_rad", -0.1, "expected a finite number above 0, got -0.1"),
        ("step_rad", np.nan, "expected a finite number above 0, got nan"),
        ("T_camera_laser", 2 * np.eye(4), r"expected \[0, 0, 0, 1\] as last row, got \[0, 0, 0, 2\]"),
        ("to_ground", [0, 0, 0], r"expected a length above 0, got \(0, 0, 0\)"),
        ("to_ground", [0, np.nan, 1], "expected finite numbers, got nan at index 1"),
        ("to_ground", [0, 1], r"expected shape \[3\], got \[2\]"),
        ("width", 0, "expected at least 1, got 0"),
        ("height", -3, "expected at least 1, got -3"),
        ("heights", [], "expected at least one, got none"),
        ("heights", [1.0, 0.0], "expected finite numbers above 0, got 0 at index 1"),
        ("heights", [-1.0], "expected finite numbers above 0, got -1 at index 0"),
        ("heights", [np.inf], "expected finite numbers above 0, got inf at index 0"),
        ("width_step", -0.5, "expected a finite number of at least 0, got -0.5"),
        ("width_step", np.inf, "expected a finite number of at least 0, got inf"),
        ("min_visible", 0.0, "expected above 0 and at most 1, got 0"),
        ("min_visible", 1.0000001, "expected above 0 and at most 1, got 1.0000001"),
        ("min_visible", np.nan, "expected above 0 and at most 1, got nan"),
    ],
)
def test_an_argument_that_cannot_be_is_refused_by_name(argument: str, value, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{argument}: {message}$"):
        candidate_boxes(**{**GOOD, argument: value})
