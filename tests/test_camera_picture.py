# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures of blind cameras are told from pictures of something, and repeated ones from new ones."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camera_scenes import flat, scene
from edgefusion.drivers.camera_picture import BLACK_LEVEL, WHITE_LEVEL, Repetition, Sight, sight


def noisy(image: np.ndarray, sigma: float, seed: int = 0) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0, sigma, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


def large(level: int) -> np.ndarray:
    return np.full((480, 640, 3), level, np.uint8)


@pytest.mark.parametrize(
    ("level", "expected"), [(0, Sight.BLACK), (255, Sight.WHITE), (128, Sight.COVERED), (40, Sight.COVERED)]
)
@pytest.mark.parametrize("sigma", [0, 3, 8])
def test_flat_pictures_are_black_white_or_covered_with_the_noise_of_a_sensor_too(level, expected, sigma) -> None:
    assert sight(noisy(large(level), sigma)) is expected


@given(st.integers(0, 255))
def test_no_flat_picture_is_clear(level: int) -> None:
    expected = Sight.BLACK if level < BLACK_LEVEL else Sight.WHITE if level > WHITE_LEVEL else Sight.COVERED
    assert sight(flat(level)) is expected


def test_light_that_leaks_round_a_finger_is_covered() -> None:
    gradient = np.linspace(0, 200, 640)[None, :, None] * np.linspace(0.3, 1, 480)[:, None, None]
    assert sight(noisy(gradient * np.ones(3), 4)) is Sight.COVERED


def test_a_slit_of_light_at_the_edge_of_a_cover_is_covered_still() -> None:
    image = large(90)
    image[:16, 300:340] = 255
    assert sight(noisy(image, 3)) is Sight.COVERED


@pytest.mark.parametrize("axis", [0, 1])
def test_edges_of_one_direction_are_enough(axis: int) -> None:
    image = large(60)
    np.moveaxis(image, axis, 0)[::40] = 180
    np.moveaxis(image, axis, 0)[1::40] = 180
    assert sight(image) is Sight.CLEAR


def test_a_few_hot_pixels_do_not_make_a_black_picture_clear() -> None:
    image = large(0)
    rows, columns = np.random.default_rng(1).integers(0, (480, 640), (30, 2)).T
    image[rows, columns] = 255
    assert sight(image) is Sight.BLACK


@given(st.integers(0, 10**6), st.sampled_from([(160, 120), (640, 480), (1280, 720), (64, 48)]))
def test_a_scene_is_clear_at_any_size(seed: int, size: tuple[int, int]) -> None:
    assert sight(scene(seed, *size)) is Sight.CLEAR


def test_a_dim_scene_is_clear() -> None:
    assert sight(noisy(scene(3, 640, 480) // 6, 2)) is Sight.CLEAR


def test_every_photograph_is_clear(shared_data: Path) -> None:
    paths = [path for ending in ("jpg", "png") for path in sorted(shared_data.rglob(f"*.{ending}"))][:40]
    assert paths
    assert [path.name for path in paths if sight(cv2.imread(str(path))) is not Sight.CLEAR] == []


def test_the_same_picture_lasts_from_when_it_first_came() -> None:
    repetition, image = Repetition(), scene(1)
    assert [repetition.lasts_ns(stamp, image.copy()) for stamp in (5, 15, 40)] == [0, 10, 35]


def test_one_grey_level_of_one_pixel_makes_a_new_picture() -> None:
    repetition, image = Repetition(), scene(1)
    repetition.lasts_ns(0, image)
    other = image.copy()
    other[-1, -1, 2] ^= 1
    assert repetition.lasts_ns(10, other) == 0
    assert repetition.lasts_ns(20, image) == 0


def test_a_picture_of_another_size_is_a_new_one() -> None:
    repetition = Repetition()
    repetition.lasts_ns(0, flat(7))
    assert repetition.lasts_ns(10, large(7)) == 0
