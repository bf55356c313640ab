# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the doctor says of a model, what it runs on, and a calibration."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from doctor_scenes import examination, told
from edgefusion.sim.rig import Rig
from edgefusion.tools.arguments import LAB_MODEL
from edgefusion.tools.doctor_camera import check_camera
from edgefusion.tools.doctor_finding import Examination
from edgefusion.tools.doctor_vision import check_calibration, check_model

pytest.importorskip("onnxruntime")


def calibration(folder: Path, **changes: object) -> Path:
    """The file of the simulator's rig, with changes."""
    rig = Rig()
    content = {
        "version": 1,
        "image_size": list(rig.image_size),
        "K": np.asarray(rig.K, float).tolist(),
        "T_camera_laser": np.asarray(rig.T_camera_laser, float).tolist(),
        "T_base_laser": np.asarray(rig.T_base_laser, float).tolist(),
        "laser_height_m": rig.laser_height_m,
        **changes,
    }
    path = folder / "calibration.toml"
    path.write_text("".join(f"{name} = {value}\n" for name, value in content.items()), "utf-8")
    return path


def exam(folder: Path, model: Path | str = LAB_MODEL, **changes: Any) -> Examination:
    vision = {"model": str(model), "calibration": str(calibration(folder)), "threads": 1, **changes.pop("vision", {})}
    return examination(folder, vision=vision, service={"processes": ("vision",)}, **changes)


def test_a_good_model_is_told_with_its_provider_and_how_near_its_golden_answer_is(tmp_path: Path) -> None:
    (finding,) = check_model(exam(tmp_path))
    assert told([finding]) == ["ok model"]
    assert "labels, on cpu, its golden answer is within " in finding.text


def flip(folder: Path) -> None:
    data = bytearray((folder / "model.onnx").read_bytes())
    data[len(data) // 2] ^= 1
    (folder / "model.onnx").write_bytes(bytes(data))


def remove(folder: Path) -> None:
    (folder / "labels.txt").unlink()


@pytest.mark.parametrize(("breaks", "text"), [(flip, "model.onnx"), (remove, "labels.txt"), (shutil.rmtree, "nothing")])
def test_a_broken_model_is_refused_by_name(tmp_path: Path, breaks: Any, text: str) -> None:
    folder = tmp_path / "model"
    shutil.copytree(LAB_MODEL, folder)
    breaks(folder)
    (finding,) = check_model(exam(tmp_path, folder))
    assert told([finding]) == ["failed model"]
    assert str(folder) in finding.text and text in finding.text
    assert "edgefusion model check" in finding.cure


def test_a_provider_that_is_not_there_is_warned_of_or_refused_where_it_is_required(tmp_path: Path) -> None:
    (finding,) = check_model(exam(tmp_path, vision={"provider": "tensorrt"}))
    assert told([finding]) == ["warning model"]
    assert "on cpu" in finding.text and "tensorrt" in finding.text
    (finding,) = check_model(exam(tmp_path, vision={"provider": "tensorrt", "require_provider": True}))
    assert told([finding]) == ["failed model"]


def test_an_object_of_interest_that_the_model_cannot_name_is_told_with_what_comes_near(tmp_path: Path) -> None:
    model, interest = check_model(exam(tmp_path, mission={"interest": ("oscilloskope",)}))
    assert told([model, interest]) == ["ok model", "failed model"]
    assert "did you mean oscilloscope?" in interest.text


def test_groups_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    *_, finding = check_model(exam(tmp_path, vision={"groups": str(tmp_path / "none.toml")}))
    assert told([finding]) == ["failed model"]
    assert "none.toml: cannot be read" in finding.text


@pytest.mark.parametrize("check", [check_model, check_calibration, check_camera])
def test_what_only_vision_needs_is_skipped_where_it_does_not_run_with_the_reason(check: Any, tmp_path: Path) -> None:
    (without_a_model,) = check(examination(tmp_path))
    (elsewhere,) = check(examination(tmp_path, service={"processes": ("bus", "base")}))
    assert [each.state.value for each in (without_a_model, elsewhere)] == ["skipped"] * 2
    assert without_a_model.text == "[vision] has no model: the robot only drives"
    assert elsewhere.text == "vision runs on another machine"


def test_a_calibration_that_fits_is_told(tmp_path: Path) -> None:
    examined = exam(tmp_path)
    examined.picture_size = Rig().image_size
    (finding,) = check_calibration(examined)
    assert told([finding]) == ["ok calibration"]
    assert "for pictures of 640x480" in finding.text


def test_a_calibration_of_another_camera_is_refused(tmp_path: Path) -> None:
    examined = exam(tmp_path)
    examined.picture_size = (1280, 720)
    (finding,) = check_calibration(examined)
    assert told([finding]) == ["failed calibration"]
    assert "for pictures of 640x480, the camera gives 1280x720" in finding.text


@pytest.mark.parametrize(
    ("laser_pose", "state"),
    [((0.12, 0.01, 0.02), "ok"), ((0.2, 0.0, 0.0), "warning"), ((0.1, 0.0, 0.1), "warning")],
)
def test_a_laser_that_is_in_two_places_is_warned_of(tmp_path: Path, laser_pose: tuple[float, ...], state: str) -> None:
    T = np.eye(4)
    T[:3, 3] = 0.11, 0.0, 0.35
    calibration(tmp_path, T_base_laser=T.tolist())
    examined = exam(tmp_path, base={"laser_pose": laser_pose})
    calibration(tmp_path, T_base_laser=T.tolist())
    assert told(list(check_calibration(examined))) == [f"{state} calibration"]


def test_a_calibration_that_cannot_be_is_refused_with_its_reason(tmp_path: Path) -> None:
    examined = exam(tmp_path)
    calibration(tmp_path, laser_height_m=-1.0)
    (finding,) = check_calibration(examined)
    assert told([finding]) == ["failed calibration"]
    assert "laser_height_m: expected above 0" in finding.text
