# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One calibration file, read strictly; a geometry that cannot be is refused by name."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.perception.calibration import load_calibration

TOML = {
    "version": "1",
    "image_size": "[640, 480]",
    "K": "[[500.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]]",
    "distortion": "[-0.1, 0.01, 0.0, 0.0]",
    "T_camera_laser": "[[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]",
    "laser_height_m": "0.3",
}


def write_toml(path: Path, **changes: str) -> Path:
    content = {**TOML, **changes}
    path.write_text("".join(f"{k} = {v}\n" for k, v in content.items() if v), encoding="utf-8")
    return path


def write_json(path: Path, **changes: object) -> Path:
    content = {
        "image_size": [640, 480],
        "K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]],
        "distortion": [0, 0, 0, 0, 0],
        "laser_to_camera": {"R": [[0, -1, 0], [0, 0, -1], [1, 0, 0]], "t": [0, 0.2, 0]},
        "laser_height_m": 0.3,
    }
    path.write_text(json.dumps({**content, **changes}), encoding="utf-8")
    return path


def test_both_formats_mean_the_same(tmp_path: Path) -> None:
    from_toml = load_calibration(write_toml(tmp_path / "c.toml", distortion="[0, 0, 0, 0, 0]"))
    from_json = load_calibration(write_json(tmp_path / "c.json"))
    for name in ("K", "T_camera_laser", "T_base_laser", "to_ground"):
        np.testing.assert_array_equal(getattr(from_toml, name), getattr(from_json, name))
    assert from_toml.image_size == from_json.image_size
    assert from_toml.distortion == from_json.distortion


def test_a_level_laser_has_the_ground_straight_below(tmp_path: Path) -> None:
    assert load_calibration(write_toml(tmp_path / "c.toml")).to_ground.tolist() == [0, 0, -0.3]


def test_a_laser_mounted_upside_down_has_the_ground_along_its_z(tmp_path: Path) -> None:
    upside_down = "[[1, 0, 0, 0.1], [0, -1, 0, 0], [0, 0, -1, 0.3], [0, 0, 0, 1]]"
    camera = "[[0, 1, 0, 0], [0, 0, 1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]"
    path = write_toml(tmp_path / "c.toml", T_base_laser=upside_down, T_camera_laser=camera)
    assert load_calibration(path).to_ground.tolist() == [0, 0, 0.3]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"K": "[[-500, 0, 320], [0, 500, 240], [0, 0, 1]]"}, "K: expected focal lengths above 0"),
        ({"K": "[[500, 0, 3200], [0, 500, 240], [0, 0, 1]]"}, "K: expected the principal point inside"),
        ({"K": "[[500, 0, 320], [0, 500, 240]]"}, r"K: expected shape \[3, 3\], got \[2, 3\]"),
        ({"K": "[[500, 0], [0, 500, 240], [0, 0, 1]]"}, r"K: expected shape \[3, 3\]"),
        ({"K": "[[nan, 0, 320], [0, 500, 240], [0, 0, 1]]"}, "K: expected finite values"),
        ({"distortion": "[0.1, 0.2]"}, "distortion: expected 0, 4, 5, 8, 12 or 14 coefficients, got 2"),
        ({"laser_height_m": "-0.3"}, "laser_height_m: expected above 0"),
        ({"laser_height_m": "nan"}, "laser_height_m: expected above 0"),
        ({"image_size": "[0, 480]"}, "image_size: expected"),
        (
            {"T_camera_laser": "[[0, -2, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]"},
            "T_camera_laser: expected a rotation",
        ),
        (
            {"T_camera_laser": "[[0, 1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]"},
            "T_camera_laser: expected a rotation",  # a mirror
        ),
        (
            {"T_camera_laser": "[[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]"},
            "T_camera_laser: expected the camera upright",  # inverted
        ),
        (
            {
                "T_camera_laser": "[[0, -1, 0, 0], [0, 0, -1, 9], [1, 0, 0, 0], [0, 0, 0, 1]]",
                "K": "[[2000, 0, 320], [0, 2000, 240], [0, 0, 1]]",
            },
            "T_camera_laser: no beam",  # a telephoto lens 9 m above the laser
        ),
        (
            {"T_camera_laser": "[[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, -40], [0, 0, 0, 1]]"},
            "T_camera_laser: expected a translation of at most 10 m, got 40",
        ),
        (
            {"T_base_laser": "[[1, 0, 0, 250], [0, 1, 0, 0], [0, 0, 1, 0.3], [0, 0, 0, 1]]"},
            "T_base_laser: expected a translation of at most 10 m, got 250",
        ),
        (
            {"K": "[[1, 0, 320], [0, 500, 240], [0, 0, 1]]"},
            "K: expected a horizontal field of view of 5 to 170 degrees, got 179.6, for 1 px",
        ),
        (
            {"K": "[[9000, 0, 320], [0, 9000, 240], [0, 0, 1]]"},
            "K: expected a horizontal field of view of 5 to 170 degrees, got 4.1",
        ),
        ({"camera_latency_ns": "10000000001"}, "camera_latency_ns: expected at most 10000000000 either way"),
        ({"laser_latency_ns": "-10000000001"}, "laser_latency_ns: expected at most 10000000000 either way"),
        ({"laser_height": "0.3"}, "unknown field"),
        ({"laser_height_m": ""}, "missing required field `laser_height_m`"),
        ({"version": "2"}, "version"),
    ],
)
def test_an_absurd_calibration_is_refused_in_one_line_with_its_file(
    tmp_path: Path, changes: dict[str, str], expected: str
) -> None:
    path = write_toml(tmp_path / "calibration.toml", **changes)
    with pytest.raises(RefusedError, match=expected) as refused:
        load_calibration(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{", "calibration.json: not JSON"),
        ("{}", "missing required field"),
        ("[]", "Expected `object`"),
        ("[" * 100000, "calibration.json: "),
    ],
    ids=["cut off", "empty", "a list", "nested deeply"],
)
def test_a_broken_json_calibration_is_refused_by_name(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "calibration.json").write_text(text, encoding="utf-8")
    with pytest.raises(RefusedError, match=expected):
        load_calibration(tmp_path / "calibration.json")


def test_the_real_calibration_is_read(shared_data: Path) -> None:
    calibration = load_calibration(shared_data / "kitti-drive" / "calibration.json")
    assert calibration.image_size == (1242, 375)
    assert calibration.laser_height_m == 0.59
