# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""I1 and I2: a model that is not the one it was is never started with, and a GPU that is lost costs no detection."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Callable, Dict, Iterable

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.lost_gpu import lost_gpu
from benchmarks.model_damage import CUTS, FLIPS, LAB_MODEL, ModelCopy

from edgefusion.bus import topics
from edgefusion.bus.healths import Healths
from edgefusion.cli import main
from edgefusion.clock import system_clock
from edgefusion.config import PerceptionConfig
from edgefusion.errors import RefusedError
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import LABELS, MODEL, read_labels
from edgefusion.perception.network import RuntimeOptions
from edgefusion.types import Detection, Health, HealthState
from make_colour_network import save_colour_network
from make_onnx import save_tiny
from scene import OBJECTS
from vision_lab import VisionLab

REAL = "squeezenet1_1_int8_qdq"
COLOURS = {solid.name: solid.color for solid in OBJECTS}


SHARE = {"lab": 1.0, REAL: 0.2}
"""`make faults` does all of it with both."""


@pytest.fixture(scope="module", params=list(SHARE))
def model(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> ModelCopy:
    folder, original = tmp_path_factory.mktemp("models"), LAB_MODEL
    if request.param == REAL:
        shared: Path = request.getfixturevalue("shared_data") / "models"
        labels, facts = read_labels(shared / "imagenet_classes.txt"), {"origin": "a test", "licence": "BSD"}
        original = make_model_folder(shared / f"{REAL}.onnx", labels, folder / "made", name=REAL, **facts).path
    return ModelCopy(original, folder / "model")


def refusal(folder: Path) -> str:
    """The one line; empty where the model is started with."""
    try:
        open_classifier(folder)
    except RefusedError as error:
        return str(error)
    return ""


def is_one_line(said: str) -> bool:
    return said != "" and "\n" not in said and "expected" in said and "got" in said


@pytest.fixture
def share(request: pytest.FixtureRequest) -> float:
    return SHARE[request.node.callspec.params["model"]]


def refused(model: ModelCopy, contents: Iterable[bytes]) -> int:
    """How many are, with one line."""
    count = 0
    for content in contents:
        with model.with_file(MODEL, content) as folder:
            count += is_one_line(refusal(folder))
    return count


def test_i1_every_flipped_bit_of_the_model_is_refused_with_one_line(model: ModelCopy, share: float) -> None:
    count = round(share * FLIPS)
    assert refused(model, model.flips(1, count)) == count
    assert refusal(model.path) == ""


def test_i1_every_truncated_model_is_refused_with_one_line(model: ModelCopy, share: float) -> None:
    count = round(share * CUTS)
    assert refused(model, model.cuts(count)) == count


@pytest.mark.parametrize("forged", [False, True])
def test_i1_a_wrong_file_and_labels_that_are_not_its_outputs_are_refused_whatever_the_checksums_say(
    model: ModelCopy, forged: bool, tmp_path: Path
) -> None:
    classes = len(read_labels(model.path / LABELS))
    another = save_tiny(tmp_path / "another.onnx", classes=classes).read_bytes()
    wrong = [(MODEL, content) for content in (*model.wrong_models.values(), another)]
    wrong += [(LABELS, content) for content in model.wrong_labels.values()]
    for name, content in wrong:
        with model.with_file(name, content, forged) as folder:
            assert is_one_line(refusal(folder)), content[:20]


def configured(folder: Path, model: Path, more: str = "") -> str:
    T = [[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]
    K = [[150.0, 0, 79.5], [0, 150.0, 59.5], [0, 0, 1]]
    (folder / "calibration.toml").write_text(
        f"version = 1\nimage_size = [160, 120]\nK = {K}\nT_camera_laser = {T}\nlaser_height_m = 0.25\n",
        encoding="utf-8",
    )
    path = folder / "robot.toml"
    path.write_text(f'[vision]\nmodel = "{model}"\ncalibration = "calibration.toml"\nthreads = 1\n{more}', "utf-8")
    return str(path)


@pytest.fixture
def no_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is refused is so before the camera is touched."""
    monkeypatch.setattr("edgefusion.service.vision_process.Camera", pytest.fail)
    monkeypatch.setattr("edgefusion.service.logs.set_up_logs", lambda *_: None)


def test_i1_vision_ends_with_2_and_doctor_with_14_and_each_says_so_in_a_line(tmp_path: Path, no_camera, capsys) -> None:
    model = ModelCopy(LAB_MODEL, tmp_path / "model")
    damages = [(MODEL, next(model.flips(seed=2))), (MODEL, b""), (LABELS, model.wrong_labels["one less"])]
    config = configured(tmp_path, model.path)
    for name, content in damages:
        with model.with_file(name, content, forged=name == LABELS):
            assert main(["vision", "--config", config]) == 2
            (line,) = capsys.readouterr().err.splitlines()
            assert is_one_line(line)
            assert main(["doctor", "--config", config, "--only", "model"]) == 14
            assert "failed   model" in capsys.readouterr().out


def test_i2_a_gpu_that_is_required_and_gone_is_refused_at_the_start(tmp_path: Path, no_camera, capsys) -> None:
    config = configured(tmp_path, LAB_MODEL, 'provider = "cuda"\nrequire_provider = true\n')
    with lost_gpu(starts=False):
        assert main(["vision", "--config", config]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "no CUDA-capable device is detected" in line


class GpuLab(VisionLab):
    """A vision on a bus, whose network names the scene's things by their colours."""

    classifier: Classifier

    def __init__(self, stack: ExitStack, folder: Path, options: RuntimeOptions) -> None:
        def detector(calibration: Any) -> Detector:
            path = save_colour_network(folder / "network", COLOURS)
            self.classifier = open_classifier(path, labels=path.parent / "labels.txt", options=options)
            return Detector(self.classifier, calibration, PerceptionConfig(max_object_width_m=1.2))

        super().__init__(stack, folder, detector)

    def until(self, holds: Callable[[], Any], timeout_s: float = 20.0) -> Any:
        def noted() -> Any:
            self.note = self.classifier.provider_note  # as run_vision() passes it on
            return holds()

        return super().until(noted, timeout_s)


@pytest.fixture
def vision(tmp_path: Path) -> Any:
    """Makes one of these options."""
    with ExitStack() as stack:
        yield lambda options: GpuLab(stack, tmp_path, options)


class Watched:
    """What a laptop hears of a vision."""

    def __init__(self, lab: GpuLab) -> None:
        self._lab = lab
        self._detail = lab.hear(topics.DETECTIONS_DETAIL, to_detections_detail)
        self._states = Healths(lab.laptop, "robot", system_clock)

    def next_detections(self) -> Dict[str, Detection]:
        """By their labels."""
        before = self._detail.value
        self._lab.until(lambda: self._detail.value is not None and self._detail.value is not before)
        assert self._detail.value is not None
        return {seen.label: seen for seen in self._detail.value.detections}

    def health(self, state: HealthState) -> Health:
        """The detector's, when it is in this state."""

        def found() -> Health | None:
            healths = [report.health for report in self._states.reports]
            return next((each for each in healths if (each.component, each.state) == ("detector", state)), None)

        health: Health = self._lab.until(found)
        return health


def test_i2_a_gpu_lost_while_it_runs_costs_no_detection_and_the_robot_says_that_it_is_degraded(vision) -> None:
    with lost_gpu() as gpu:
        watched = Watched(vision(RuntimeOptions(provider="cuda")))
        expected = watched.next_detections()
        watched.health(HealthState.OK)
        gpu.runs = 0
        health, got = watched.health(HealthState.DEGRADED), watched.next_detections()
    assert health.reason.startswith("cuda failed, cpu has taken over: CUDA failure 719")
    assert gpu.failures == 1
    assert_same(got, expected)


def test_i2_a_gpu_that_is_gone_at_the_start_costs_no_detection_and_the_robot_says_that_it_is_degraded(vision) -> None:
    with lost_gpu():
        watched = Watched(vision(RuntimeOptions(provider="cuda")))
        expected = watched.next_detections()
    with lost_gpu(starts=False):
        watched = Watched(vision(RuntimeOptions(provider="cuda")))
        got, health = watched.next_detections(), watched.health(HealthState.DEGRADED)
    assert health.reason == "asked for cuda, got cpu: CUDA failure 100: no CUDA-capable device is detected"
    assert_same(got, expected)


def assert_same(got: Dict[str, Detection], expected: Dict[str, Detection]) -> None:
    assert set(got) == set(expected) == set(COLOURS)
    scores = [[seen[label].score for label in sorted(COLOURS)] for seen in (got, expected)]
    np.testing.assert_allclose(*scores, atol=1e-3)


def test_i2_a_required_gpu_lost_while_it_runs_ends_vision(vision) -> None:
    with lost_gpu() as gpu:
        lab = vision(RuntimeOptions(require="cuda"))
        watched = Watched(lab)
        watched.next_detections()
        gpu.runs = 0
        with pytest.raises(RuntimeError, match="cuda failed: CUDA failure 719"):
            watched.next_detections()
