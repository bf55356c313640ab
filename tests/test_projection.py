# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Laser points into pixels: OpenCV is the reference, and what it gets silently wrong is marked."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion._core import BEHIND, BEYOND, VISIBLE, Camera, project, project_paper

# Typical sizes of OpenCV's 14 coefficients: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y.
SCALES = np.array([0.3, 0.1, 2e-3, 2e-3, 0.05, 0.1, 0.05, 0.02, 2e-3, 2e-3, 2e-3, 2e-3, 0.02, 0.02])
ROBOT_TO_CAMERA = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]], float)


def random_camera(rng: np.random.Generator, coefficients: int) -> tuple[np.ndarray, list[float], np.ndarray]:
    fx, fy = rng.uniform(300, 900, 2)
    K = np.array([[fx, 0, rng.uniform(200, 400)], [0, fy, rng.uniform(150, 300)], [0, 0, 1]])
    T = np.eye(4)
    T[:3, :3] = cv2.Rodrigues(rng.normal(0, 1, 3))[0]
    T[:3, 3] = rng.normal(0, 1, 3)
    return K, (rng.normal(0, 1, coefficients) * SCALES[:coefficients]).tolist(), T


def opencv_pixels(points: np.ndarray, K: np.ndarray, distortion: list[float], T: np.ndarray) -> np.ndarray:
    turn = cv2.Rodrigues(T[:3, :3])[0]
    coefficients = np.array(distortion) if distortion else None
    pixels, _ = cv2.projectPoints(points.reshape(-1, 1, 3), turn, T[:3, 3].copy(), K, coefficients)
    return pixels.reshape(-1, 2)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0, 4, 5, 8, 12, 14]))
def test_visible_pixels_are_those_of_opencv(seed: int, coefficients: int) -> None:
    rng = np.random.default_rng(seed)
    K, distortion, T = random_camera(rng, coefficients)
    points = rng.uniform(-5, 5, (50, 3))
    pixels, marks = project(points, K, distortion, T)
    expected = opencv_pixels(points, K, distortion, T)
    # Within ten image widths of the image: far outside, a microscopic rounding is many pixels.
    near = (marks == VISIBLE) & (np.abs(expected) < 10_000).all(axis=1)
    np.testing.assert_allclose(pixels[near], expected[near], atol=1e-6, rtol=0)


@given(st.integers(0, 2**32 - 1))
def test_every_point_behind_the_camera_is_marked_and_has_no_pixel(seed: int) -> None:
    rng = np.random.default_rng(seed)
    K, distortion, T = random_camera(rng, 5)
    points = rng.uniform(-5, 5, (100, 3))
    pixels, marks = project(points, K, distortion, T)
    behind = points @ T[2, :3] + T[2, 3] <= 0
    assert ((marks == BEHIND) == behind).all()
    assert np.isnan(pixels[marks != VISIBLE]).all()
    assert np.isfinite(pixels[marks == VISIBLE]).all()


@given(st.integers(0, 2**32 - 1), st.sampled_from([4, 5, 8]))
def test_the_distorted_radius_grows_up_to_the_end_of_the_valid_region_and_no_further(
    seed: int, coefficients: int
) -> None:
    rng = np.random.default_rng(seed)
    distortion = rng.normal(0, 1, coefficients) * SCALES[:coefficients]
    distortion[2:4] = 0  # tangential terms are no function of the radius
    k1, k2, _, _, k3, k4, k5, k6 = np.pad(distortion, (0, 8 - coefficients))
    end = Camera(np.diag([500.0, 500.0, 1.0]), distortion.tolist()).max_radius

    def distorted(r: np.ndarray) -> np.ndarray:
        u = r**2
        return r * (1 + u * (k1 + u * (k2 + u * k3))) / (1 + u * (k4 + u * (k5 + u * k6)))

    inside = distorted(np.linspace(0, min(end, 50) * (1 - 1e-9), 4000))
    assert (np.diff(inside) > 0).all()
    if end < 50:
        beyond = distorted(end * np.array([1 + 1e-6, 1 + 2e-4]))
        assert beyond[1] <= beyond[0] or not np.isfinite(beyond).all() or beyond[0] < 0


def test_a_wall_61_degrees_off_axis_does_not_land_in_the_picture() -> None:
    K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1]], float)
    wall = np.array([[1.0, -np.tan(np.radians(61)), 0.0]])
    assert 0 < opencv_pixels(wall, K, [-0.3, 0, 0, 0], ROBOT_TO_CAMERA)[0, 0] < 640  # what OpenCV would say
    pixels, marks = project(wall, K, [-0.3, 0, 0, 0], ROBOT_TO_CAMERA)
    assert marks.tolist() == [BEYOND]
    assert np.isnan(pixels).all()


@given(st.floats(0.2, 20), st.floats(-5, 5), st.floats(-3, 3))
def test_the_papers_form_agrees_where_the_principal_point_is_the_centre(x: float, y: float, z: float) -> None:
    K = np.array([[525, 0, 320], [0, 510, 240], [0, 0, 1]], float)
    pixels, _ = project([[x, y, z]], K, [], ROBOT_TO_CAMERA)
    np.testing.assert_allclose(project_paper([[x, y, z]], K, 640, 480), pixels, atol=1e-8, rtol=1e-9)


@given(st.integers(0, 2**32 - 1), st.sampled_from([4, 5, 8, 12, 14]))
def test_no_visible_point_lies_where_opencvs_picture_is_turned_over(seed: int, coefficients: int) -> None:
    rng = np.random.default_rng(seed)
    _, distortion, _ = random_camera(rng, coefficients)
    distortion = (np.array(distortion) * 5).tolist()  # so that it folds within the view
    points = np.concatenate([rng.uniform(-1.5, 1.5, (60, 2)), np.ones((60, 1))], axis=1)
    _, marks = project(points, np.eye(3), distortion, np.eye(4))
    step = 1e-6
    at, right, below = (
        opencv_pixels(points + move, np.eye(3), distortion, np.eye(4))
        for move in ([0, 0, 0], [step, 0, 0], [0, step, 0])
    )
    turn = np.linalg.det(np.stack([right - at, below - at], axis=1) / step)
    assert (turn[marks == VISIBLE] > -1e-3).all()


def test_a_pixel_that_overflows_is_beyond() -> None:
    pixels, marks = project([[1e-60, 1, 0]], np.eye(3), [], ROBOT_TO_CAMERA)
    assert marks.tolist() == [BEYOND]
    assert np.isnan(pixels).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_point_that_is_not_finite_is_refused_by_row(value: float) -> None:
    points = np.ones((5, 3))
    points[3, 1] = value
    message = rf"^points: expected finite coordinates, got \(1, {value}, 1\) in row 3$"
    with pytest.raises(ValueError, match=message):
        project(points, np.eye(3), [], np.eye(4))
    with pytest.raises(ValueError, match=message):
        project_paper(points, np.eye(3), 640, 480)


@pytest.mark.parametrize("shape", [(-1,), (1, -1), (-1, 1)])
@pytest.mark.parametrize("coefficients", [4, 5, 8, 12, 14])
def test_coefficients_may_come_as_opencv_hands_them_out(shape: tuple[int, ...], coefficients: int) -> None:
    distortion = SCALES[:coefficients] / 10
    points = np.random.default_rng(1).uniform(1, 3, (20, 3))
    expected, _ = project(points, np.eye(3), distortion.tolist(), ROBOT_TO_CAMERA)
    camera = Camera(np.eye(3), distortion.reshape(shape))
    np.testing.assert_array_equal(project(points, camera, ROBOT_TO_CAMERA)[0], expected)
    np.testing.assert_array_equal(project(points, np.eye(3), distortion.reshape(shape), ROBOT_TO_CAMERA)[0], expected)


SHEARED = np.eye(4)
SHEARED[3] = 0, 0, 0.5, 1
UNKNOWN = np.full((4, 4), np.nan)


def test_the_papers_form_mirrors_a_principal_point_off_the_centre() -> None:
    K = np.array([[525, 0, 300], [0, 510, 250], [0, 0, 1]], float)
    pixels, _ = project([[2.0, 0.3, 0.1]], K, [], ROBOT_TO_CAMERA)
    # It puts the principal point at (width - cx, height - cy).
    np.testing.assert_allclose(project_paper([[2.0, 0.3, 0.1]], K, 640, 480) - pixels, [[40, -20]])


def test_the_papers_form_has_no_pixel_behind_the_camera() -> None:
    K = np.array([[525, 0, 320], [0, 510, 240], [0, 0, 1]], float)
    assert np.isnan(project_paper([[-1, 0, 0], [0, 1, 0]], K, 640, 480)).all()


@pytest.mark.parametrize(
    ("points", "K", "distortion", "T", "named"),
    [
        (np.zeros((3, 2)), np.eye(3), [], np.eye(4), r"points: expected shape \[n, 3\], got \[3, 2\]"),
        (np.zeros((3, 3)), np.eye(2), [], np.eye(4), r"K: expected shape \[3, 3\]"),
        (
            np.zeros((3, 3)),
            np.eye(3),
            [0.1],
            np.eye(4),
            r"distortion: expected 0, 4, 5, 8, 12 or 14 .* got 1",
        ),
        (np.zeros((3, 3)), np.eye(3), [], np.eye(3), r"T_camera_laser: expected shape \[4, 4\]"),
        (np.zeros((3, 3)), -np.eye(3), [], np.eye(4), r"K: expected focal lengths above 0, got -1 and -1"),
        (np.zeros((3, 3)), np.eye(3), np.zeros((2, 4)), np.eye(4), r"distortion: expected shape \[n\], \[1, n\] or"),
        (np.zeros((3, 3)), np.eye(3), ["0"] * 4, np.eye(4), r"distortion: expected real numbers, got <U1"),
        (np.zeros((3, 3)), np.eye(3), [0, 0, np.nan, 0], np.eye(4), r"distortion: expected .* got nan at index 2"),
        (np.zeros((3, 3)), np.eye(3), [], SHEARED, r"T_camera_laser: expected \[0, 0, 0, 1\] .* got \[0, 0, 0.5, 1\]"),
        (np.zeros((3, 3)), np.eye(3), [], UNKNOWN, r"T_camera_laser: expected finite numbers"),
        ([["1", "2", "3"]], np.eye(3), [], np.eye(4), r"points: expected real numbers, got <U1"),
        ([[1, 2, 3j]], np.eye(3), [], np.eye(4), r"points: expected real numbers, got complex128"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(points, K, distortion, T, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        project(points, K, distortion, T)


def test_no_points_give_no_pixels() -> None:
    pixels, marks = project(np.empty((0, 3)), np.eye(3), [], np.eye(4))
    assert pixels.shape == (0, 2)
    assert marks.shape == (0,)
