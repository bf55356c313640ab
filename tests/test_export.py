# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import contextlib
import importlib.util
import io
import runpy
import subprocess
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
import pytest

from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.onnx_header import read_onnx_header
from make_onnx import save_labels

SCRIPT = Path(__file__).resolve().parents[1] / "models" / "export.py"
MISSING = [name for name in ("torch", "torchvision") if importlib.util.find_spec(name) is None]
needs_torch = [
    pytest.mark.torch,
    pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)} (the extra 'export')"),
]
LABELS = [f"class {i}" for i in range(14)]


class Result(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


def export(*arguments):
    """What `python models/export.py ...` does. In this process, since importing torch takes seconds."""
    out, err = io.StringIO(), io.StringIO()
    with warnings.catch_warnings(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        warnings.simplefilter("ignore")  # torch's own
        sys.path.insert(0, str(SCRIPT.parent))
        try:
            code = runpy.run_path(str(SCRIPT))["main"]([str(argument) for argument in arguments])
        finally:
            sys.path.remove(str(SCRIPT.parent))
    return Result(code, out.getvalue(), err.getvalue())


def refusal(result):
    """The one line of a refused export."""
    assert result.returncode == 2, result.stderr
    line = result.stderr.strip().splitlines()[-1]
    assert "expected" in line
    assert "got" in line
    return line


def tiny(labels, out):
    """The arguments of a small network that knows nothing."""
    return ("--arch", "shufflenet_v2_x0_5", "--random", "--labels", labels, "--size", 64, "--out", out)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    result = export(*tiny(save_labels(folder / "labels.txt", LABELS), folder / "tiny"))
    assert result.returncode == 0, result.stderr
    return folder / "tiny", result.stdout


class TestExport:
    pytestmark = needs_torch

    def test_the_folder_holds_a_network_that_the_jetsons_runtime_reads(self, exported):
        folder, _ = exported
        header = read_onnx_header((folder / "model.onnx").read_bytes())
        assert header.opset == 13
        assert header.ir_version <= 8
        assert (folder / "model.onnx").stat().st_size < 1.6e6

    def test_every_step_is_reported(self, exported):
        _, said = exported
        for line in (
            "random weights, seed 0",
            "all batch norms folded",
            "agrees with torch",
            "golden answer",
        ):
            assert line in said

    def test_it_is_opened_and_takes_images_of_any_size_in_any_number(self, exported):
        classifier = open_classifier(exported[0])
        assert classifier.labels == tuple(LABELS)
        assert classifier.golden_difference < 1e-3
        image = np.random.default_rng(0).integers(0, 256, (50, 70, 3), np.uint8)
        for boxes in ([(0, 0, 70, 50)], [(0, 0, 20, 20), (5, 5, 70, 50), (1, 1, 2, 2)]):
            assert classifier.probabilities(image, boxes).shape == (len(boxes), 14)

    def test_it_answers_differently_to_different_pictures(self, exported):
        classifier = open_classifier(exported[0])
        rng = np.random.default_rng(1)
        boxes = [(0, 0, 64, 64)]
        flat = [np.full((64, 64, 3), rng.integers(0, 256, 3), np.uint8) for _ in range(20)]
        assert len({int(classifier.probabilities(image, boxes).argmax()) for image in flat}) > 1

    def test_a_trained_state_is_taken_from_a_file(self, exported, tmp_path):
        import torch  # torchvision's operators are in place since `exported`
        import torchvision

        torch.manual_seed(3)
        network = torchvision.models.resnet18(num_classes=len(LABELS))
        network.fc.weight.data *= 30  # lively enough for a golden answer
        torch.save({"model": network.state_dict()}, tmp_path / "mine.pth")
        labels = save_labels(tmp_path / "labels.txt", LABELS)
        options = ("--weights", tmp_path / "mine.pth", "--labels", labels, "--size", 64)
        result = export(*options, "--out", tmp_path / "out")
        assert result.returncode == 0, result.stderr
        assert "all batch norms folded" in result.stdout
        manifest = msgspec.toml.decode((tmp_path / "out" / "manifest.toml").read_bytes())
        assert manifest["origin"].endswith("weights of mine.pth")
        open_classifier(tmp_path / "out")

    def test_weights_of_another_network_are_refused(self, tmp_path):
        labels = save_labels(tmp_path / "labels.txt", LABELS)
        (tmp_path / "mine.pth").write_bytes(b"none")
        result = export("--weights", tmp_path / "mine.pth", "--labels", labels, "--out", tmp_path / "out")
        assert "mine.pth: expected weights for this network" in refusal(result)
        assert not (tmp_path / "out").exists()

    def test_weights_that_cannot_be_downloaded_are_refused_with_a_way_out(self, tmp_path, monkeypatch):
        for name in ("https_proxy", "HTTPS_PROXY"):
            monkeypatch.setenv(name, "http://127.0.0.1:9")  # the discard port: nobody listens
        monkeypatch.setenv("TORCH_HOME", str(tmp_path))
        assert "--weights FILE" in refusal(export("--out", tmp_path / "out"))

    def test_an_unknown_architecture_is_refused(self, tmp_path):
        result = export("--arch", "resnet19", "--random", "--out", tmp_path / "out")
        assert "--arch: expected a classifier of torchvision" in refusal(result)


def test_without_torch_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    line = refusal(export("--random", "--out", tmp_path / "out"))
    assert "pip install 'edgefusion[cpu,export]'" in line


def test_an_existing_folder_is_refused_before_any_work(tmp_path):
    assert "not there yet" in refusal(export("--out", tmp_path))


def test_the_script_runs_by_itself_and_its_help_gives_examples():
    result = subprocess.run([sys.executable, SCRIPT, "--help"], capture_output=True, text=True, check=True)
    assert "python models/export.py --out models/resnet18" in result.stdout
