# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The classifier that ships: small, readable by old runtimes, and trained on the kinds that there are."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import edgefusion
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.model_folder import load_model_folder
from edgefusion.perception.onnx_header import read_onnx_header
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.types import BACKGROUND, UNKNOWN

LAB = Path(edgefusion.__file__).parent / "data" / "lab-model"
MODELS = Path(__file__).resolve().parents[1] / "models"


def test_it_takes_two_megabytes_at_most_and_runs_on_onnx_runtime_1_11() -> None:
    assert sum(file.stat().st_size for file in LAB.iterdir()) <= 2e6
    header = read_onnx_header((LAB / "model.onnx").read_bytes())
    assert header.opset == 13
    assert header.ir_version <= 8


def test_it_knows_every_kind_that_has_a_name() -> None:
    labels = {kind.label for kind in CATALOGUE.values()} - {UNKNOWN}
    assert set(open_classifier(LAB).labels) == labels | {BACKGROUND}


def test_its_manifest_says_how_it_was_trained_and_how_good_it_is() -> None:
    training = load_model_folder(LAB).manifest.training
    assert training is not None
    assert training.command.startswith("python models/train_lab.py ")
    assert f"--seed={training.seed}" in training.command
    assert 0.85 < training.accuracy <= 1


@pytest.fixture(scope="module")
def train_lab():
    pytest.importorskip("panda3d", reason="training renders its crops with Panda3D (the extra 'sim')")
    sys.path.insert(0, str(MODELS))
    try:
        spec = importlib.util.spec_from_file_location("train_lab", MODELS / "train_lab.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module
    finally:
        sys.path.remove(str(MODELS))


def test_it_ships_with_the_heights_that_it_was_trained_on(train_lab) -> None:
    boxes = load_model_folder(LAB).manifest.boxes
    assert boxes is not None
    assert boxes.heights == train_lab.HEIGHTS_M
    assert boxes.heights_in == "metres"


def test_a_name_is_wanted_the_surer_the_better_the_box_fits(train_lab) -> None:
    from lab_training import targets

    fits = np.linspace(0, 1, 21, dtype=np.float32)
    wanted = targets(np.full(21, 2), fits, 5)
    assert wanted.sum(axis=1) == pytest.approx(1)
    assert (np.diff(wanted[:, 2]) >= 0).all()
    assert wanted[-1, 2] == pytest.approx(1)
    assert (wanted[0, [0, 1, 3, 4]] == wanted[0, 0]).all()  # no other name is favoured
    assert (wanted.argmax(axis=1)[fits > 0.35] == 2).all()


def test_crops_repeat_and_are_labelled_by_what_they_hold(train_lab) -> None:
    from lab_crops import class_names, joined, render_crops

    preprocessing = load_model_folder(LAB).manifest.input
    first, again = (joined(list(render_crops([3, 4], 3, train_lab.HEIGHTS_M, preprocessing))) for _ in range(2))
    assert first.pixels.tobytes() == again.pixels.tobytes()
    assert len(first) == len(first.classes) == len(first.fits) == len(first.worlds) > 20
    assert set(first.worlds.tolist()) <= {3, 4}
    assert (first.classes < len(class_names())).all()
    assert ((first.fits >= 0) & (first.fits <= 1)).all()
