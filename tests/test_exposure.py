# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the simulated camera adds: noise, blur, gain and vignetting are as stated, and come from the generator alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.sim.exposure import CameraSpec, exposed

FOCAL_PX = 460.0
CLEAN = CameraSpec(gain_sigma=0.0, tint_sigma=0.0, shot=0.0, read=0.0, vignetting=0.0)
NOISY = CameraSpec(gain_sigma=0.0, tint_sigma=0.0, vignetting=0.0)


def grey(level: int, height: int = 120, width: int = 160) -> np.ndarray:
    return np.full((height, width, 3), level, np.uint8)


def take(spec: CameraSpec, clean: np.ndarray, yaw_rate_radps: float = 0.0, seed: int = 0) -> np.ndarray:
    return exposed(spec, clean, FOCAL_PX, yaw_rate_radps, np.random.default_rng(seed))


def test_the_same_generator_gives_the_same_bytes_and_another_seed_others() -> None:
    picture = take(CameraSpec(), grey(120), 0.3)
    assert take(CameraSpec(), grey(120), 0.3).tobytes() == picture.tobytes()
    assert take(CameraSpec(), grey(120), 0.3, seed=1).tobytes() != picture.tobytes()


def test_the_clean_picture_is_left_alone() -> None:
    clean = grey(120)
    take(CameraSpec(), clean, 0.5)
    assert (clean == 120).all()


def test_a_perfect_camera_delivers_what_it_is_shown() -> None:
    clean = np.random.default_rng(1).integers(0, 256, (40, 60, 3)).astype(np.uint8)
    np.testing.assert_array_equal(take(CLEAN, clean), clean)


@pytest.mark.parametrize("level", [30, 120, 220])
def test_noise_has_the_stated_deviation_and_no_bias(level: int) -> None:
    picture = take(NOISY, grey(level)).astype(float)
    sigma = math.sqrt(NOISY.read**2 + NOISY.shot**2 * level / 255)
    assert picture.std() == pytest.approx(math.sqrt(sigma**2 + 1 / 12), rel=0.02)  # 1/12: whole grey levels
    assert picture.mean() == pytest.approx(level, abs=0.05)


def test_noise_is_independent_from_pixel_to_pixel_and_colour_to_colour() -> None:
    noise = take(NOISY, grey(120)).astype(float) - 120
    for other in (np.roll(noise, 1, axis=0), np.roll(noise, 1, axis=1), np.roll(noise, 1, axis=2)):
        assert abs(np.corrcoef(noise.ravel(), other.ravel())[0, 1]) < 0.02


def test_white_stays_white_however_long_it_is_exposed() -> None:
    bright = CameraSpec(gain_sigma=1.0, tint_sigma=0, shot=0, read=0, vignetting=0)
    seed = next(seed for seed in range(20) if take(bright, grey(100), seed=seed).min() > 150)
    assert (take(bright, grey(255), seed=seed) == 255).all()


def test_black_stays_black_but_for_the_noise() -> None:
    assert take(CameraSpec(), grey(0)).max() < 6 * CameraSpec().read


@pytest.mark.parametrize(("yaw_rate_radps", "exposure_ns"), [(0.5, 40_000_000), (-0.5, 40_000_000), (1.0, 60_000_000)])
def test_an_edge_is_smeared_over_as_many_pixels_as_the_camera_turned(yaw_rate_radps: float, exposure_ns: int) -> None:
    length_px = abs(yaw_rate_radps) * exposure_ns / 1e9 * FOCAL_PX
    clean = grey(0)
    clean[:, 80:] = 250
    spec = CameraSpec(exposure_ns, gain_sigma=0, tint_sigma=0, shot=0, read=0, vignetting=0)
    profile = take(spec, clean, yaw_rate_radps)[60, :, 0].astype(float)
    slope = np.diff(profile) / 250
    at = np.arange(len(slope)) - 79
    assert slope.sum() == pytest.approx(1)
    assert (slope * at).sum() == pytest.approx(0, abs=0.05)
    assert length_px <= np.count_nonzero(slope) < length_px + 2  # the ends count in part
    # An even smear of that length has this deviation.
    assert math.sqrt((slope * at**2).sum()) == pytest.approx(length_px / math.sqrt(12), rel=0.03)


def test_turning_smears_along_rows_only() -> None:
    clean = grey(0)
    clean[60:] = 250
    np.testing.assert_array_equal(take(CLEAN, clean, 2.0), clean)


def test_gain_spreads_from_take_to_take_as_stated() -> None:
    spec = CameraSpec(gain_sigma=0.08, tint_sigma=0.0, shot=0, read=0, vignetting=0)
    levels = np.array([take(spec, grey(100, 8, 8), seed=seed).mean() for seed in range(400)])
    assert np.log(levels / 100).std() == pytest.approx(0.08, rel=0.1)
    assert np.log(levels / 100).mean() == pytest.approx(0, abs=0.015)


def test_colours_are_tinted_from_take_to_take_as_stated() -> None:
    spec = CameraSpec(gain_sigma=0.0, tint_sigma=0.05, shot=0, read=0, vignetting=0)
    levels = np.array([take(spec, grey(100, 8, 8), seed=seed).mean(axis=(0, 1)) for seed in range(400)])
    assert np.log(levels / 100).std(axis=0) == pytest.approx([0.05] * 3, rel=0.15)
    assert abs(np.corrcoef(levels[:, 0], levels[:, 2])[0, 1]) < 0.2


def test_corners_are_darker_by_the_vignetting() -> None:
    picture = take(CameraSpec(gain_sigma=0, tint_sigma=0, shot=0, read=0, vignetting=0.2), grey(200, 121, 161))
    assert picture[60, 80].tolist() == [200] * 3
    for corner in (picture[0, 0], picture[0, -1], picture[-1, 0], picture[-1, -1]):
        assert corner.tolist() == [160] * 3


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("exposure_ns", 1, "at least 2"),
        ("gain_sigma", -0.1, "a finite number of at least 0"),
        ("tint_sigma", math.inf, "a finite number of at least 0"),
        ("shot", math.nan, "a finite number of at least 0"),
        ("read", -1.0, "a finite number of at least 0"),
        ("vignetting", 1.1, "a share from 0 to 1"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(name: str, value: float, expected: str) -> None:
    with pytest.raises(RefusedError, match=f"^{name}: expected {expected}, got {value}$"):
        replace(CameraSpec(), **{name: value})
