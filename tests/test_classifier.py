# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import json
import shutil
import sys
from pathlib import Path

import cv2
import msgspec
import numpy as np
import onnx
import onnxruntime
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import numpy_helper

from edgefusion.errors import RefusedError
from edgefusion.perception import network
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import load_model_folder, read_labels
from edgefusion.perception.network import RuntimeOptions, as_probabilities
from edgefusion.perception.preprocessing import DEFAULT, IMAGENET_MEAN, IMAGENET_STD, Preprocessing, whole
from make_onnx import LABELS, edit_manifest, save_labels, save_tiny

SMALL = msgspec.structs.replace(DEFAULT, size=32)
IMAGE = np.random.default_rng(0).integers(0, 256, (60, 90, 3), np.uint8)
BOXES = [(0, 0, 90, 60), (0, 0, 40, 20), (30, 10, 50, 60), (70, 2, 71, 3)]


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    source = save_tiny(folder / "tiny.onnx")
    facts = {"name": "tiny", "origin": "a test", "licence": "Apache-2.0", "preprocessing": SMALL}
    return make_model_folder(source, LABELS, folder / "tiny", **facts).path


@pytest.fixture
def folder(original, tmp_path):
    return shutil.copytree(original, tmp_path / "tiny")


@pytest.fixture(scope="module")
def classifier(original):
    return open_classifier(original)


class FakeGpuRuntime:
    """onnxruntime with a GPU that is really the CPU. It can be absent at start, or fail at a run."""

    SessionOptions = onnxruntime.SessionOptions
    __version__ = onnxruntime.__version__

    sessions = 0

    def __init__(self, starts=True, runs=10**9, available=("CUDAExecutionProvider", "CPUExecutionProvider")):
        self.starts, self.runs, self.available = starts, runs, available

    def get_available_providers(self):
        return list(self.available)

    def InferenceSession(self, model, settings, providers, provider_options, **options):
        self.sessions += 1
        if providers[0] != "CPUExecutionProvider" and not self.starts:
            raise RuntimeError("CUDA failure 100: no CUDA-capable device is detected")
        real = onnxruntime.InferenceSession(model, settings, providers=["CPUExecutionProvider"])
        return FakeSession(self, real, providers)


class FakeSession:
    def __init__(self, runtime, real, providers):
        self.runtime, self.real, self.providers = runtime, real, providers
        self.get_inputs, self.get_outputs = real.get_inputs, real.get_outputs

    def disable_fallback(self):
        self.real.disable_fallback()

    def get_providers(self):
        return self.providers

    def run(self, names, inputs):
        if self.providers[0] != "CPUExecutionProvider":
            self.runtime.runs -= 1
            if self.runtime.runs < 0:
                raise RuntimeError("CUDA failure 719: unspecified launch failure")
        return self.real.run(names, inputs)


def with_gpu(monkeypatch, **facts):
    runtime = FakeGpuRuntime(**facts)
    monkeypatch.setattr(network, "import_onnxruntime", lambda: runtime)
    return runtime


def test_every_box_gets_a_distribution_over_the_labels(classifier):
    got = classifier.probabilities(IMAGE, BOXES)
    assert got.dtype == np.float32
    assert got.shape == (len(BOXES), len(LABELS))
    np.testing.assert_allclose(got.sum(axis=1), 1, atol=1e-6)
    assert classifier.labels == LABELS


def test_no_boxes_give_no_rows(classifier):
    assert classifier.probabilities(IMAGE, np.zeros((0, 4), np.int32)).shape == (0, len(LABELS))


@settings(deadline=None, max_examples=50)
@given(order=st.permutations(range(len(BOXES))), count=st.integers(1, len(BOXES)))
def test_a_boxs_answer_depends_on_no_other_box(classifier, order, count):
    alone = np.concatenate([classifier.probabilities(IMAGE, [box]) for box in BOXES])
    chosen = order[:count]
    together = classifier.probabilities(IMAGE, [BOXES[i] for i in chosen])
    np.testing.assert_allclose(together, alone[chosen], atol=1e-6)


def test_crops_share_one_buffer_that_grows(classifier):
    many = classifier.crop(IMAGE, BOXES * 3)
    few = classifier.crop(IMAGE, BOXES)
    assert np.shares_memory(many, few)
    assert len(few) == len(BOXES)


@pytest.mark.parametrize("shape", [(1, 3, 32, 31), (3, 32, 32), (1, 1, 32, 32)])
def test_a_batch_of_another_shape_is_refused(classifier, shape):
    with pytest.raises(ValueError, match=r"batch: expected float32 \[n, 3, 32, 32\], got"):
        classifier.infer(np.zeros(shape, np.float32))


def test_a_row_that_is_not_finite_is_all_nan_and_leaves_the_others(classifier):
    batch = classifier.crop(IMAGE, BOXES).copy()
    expected = classifier.infer(batch)
    batch[1, 0, 4, 4] = np.nan
    got = classifier.infer(batch)
    assert np.isnan(got[1]).all()
    others = [0, 2, 3]
    np.testing.assert_allclose(got[others], expected[others], atol=1e-6)


@pytest.mark.parametrize("softmax", [True, False])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_outputs_that_are_not_finite_lose_their_whole_row(softmax, bad):
    got = as_probabilities(np.float32([[0.5, 0.5], [bad, 0.5]]), softmax)
    assert np.isfinite(got[0]).all()
    assert np.isnan(got[1]).all()


def test_large_outputs_do_not_overflow():
    np.testing.assert_allclose(as_probabilities(np.float32([[3e38, 0, -3e38]]), True), [[1, 0, 0]])


@pytest.mark.parametrize("batch", [1, 3])
def test_a_network_of_a_fixed_batch_gives_the_same_answers(classifier, tmp_path, batch):
    fixed = open_bare(tmp_path, batch=batch, size=32)
    expected = classifier.probabilities(IMAGE, BOXES)
    np.testing.assert_allclose(fixed.probabilities(IMAGE, BOXES), expected, atol=1e-6)


def open_bare(tmp_path, **options):
    path = save_tiny(tmp_path / "tiny.onnx", **options)
    return open_classifier(path, save_labels(tmp_path / "labels.txt"))


def test_a_bare_model_warns_that_nothing_vouches_for_it(tmp_path, caplog):
    opened = open_bare(tmp_path)
    assert "nothing vouches for a bare model" in caplog.text
    assert opened.preprocessing == DEFAULT
    assert opened.golden_difference is None


def test_a_bare_model_of_a_fixed_size_gets_crops_of_that_size(tmp_path):
    assert open_bare(tmp_path, size=64).preprocessing.size == 64


@pytest.mark.parametrize("require", [None, "cuda"])
def test_a_bare_model_is_loaded_once(tmp_path, monkeypatch, require):
    runtime = with_gpu(monkeypatch)
    path, labels = save_tiny(tmp_path / "tiny.onnx", size=64), save_labels(tmp_path / "labels.txt")
    opened = open_classifier(path, labels, RuntimeOptions(require=require))
    assert (opened.provider, opened.preprocessing.size, runtime.sessions) == ("cuda", 64, 1)


def test_a_bare_model_without_labels_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="expected a file of labels"):
        open_classifier(save_tiny(tmp_path / "tiny.onnx"))


def test_a_bare_model_with_too_few_labels_is_refused(tmp_path):
    path, labels = save_tiny(tmp_path / "tiny.onnx"), save_labels(tmp_path / "labels.txt", LABELS[:3])
    with pytest.raises(RefusedError, match="expected a label for each of its 5 outputs, got 3 labels"):
        open_classifier(path, labels)


def test_a_bare_model_with_probabilities_gets_no_second_softmax(classifier, tmp_path):
    got = open_bare(tmp_path, softmax=True, size=32).probabilities(IMAGE, BOXES)
    np.testing.assert_allclose(got, classifier.probabilities(IMAGE, BOXES), atol=1e-6)


@pytest.mark.parametrize("liveliness", [np.nan, np.inf])
def test_a_bare_model_whose_outputs_are_not_finite_is_refused(tmp_path, liveliness):
    with pytest.raises(RefusedError, match=r"tiny\.onnx on cpu: expected finite outputs"):
        open_bare(tmp_path, liveliness=liveliness)


def test_a_bare_model_that_fails_at_its_first_run_is_refused(tmp_path):
    with pytest.raises(RefusedError, match=r"tiny\.onnx on cpu: expected a network that runs at 256 x 256") as caught:
        open_bare(tmp_path, only_size=64)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("door", ["read_bytes", "is_dir"])
def test_a_bare_model_that_must_not_be_read_is_refused(tmp_path, monkeypatch, door):
    path, labels = save_tiny(tmp_path / "tiny.onnx"), save_labels(tmp_path / "labels.txt")

    def forbidden(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, door, forbidden)
    with pytest.raises(RefusedError, match=r"tiny\.onnx: expected .* can be .*, got: Permission denied"):
        open_classifier(path, labels)


def test_labels_beside_a_folder_are_refused(folder, tmp_path):
    with pytest.raises(RefusedError, match="expected no labels beside a model folder"):
        open_classifier(folder, save_labels(tmp_path / "labels.txt"))


@pytest.mark.parametrize("labels", [None, "labels.txt"])
def test_a_model_that_is_not_there_is_named(tmp_path, labels):
    with pytest.raises(RefusedError, match=r"nope\.onnx: expected a model folder or an ONNX file, got nothing"):
        open_classifier(tmp_path / "nope.onnx", labels and save_labels(tmp_path / labels))


def test_the_golden_answer_is_met(classifier):
    assert classifier.golden_difference is not None
    assert classifier.golden_difference < 1e-5


def refuse(folder):
    with pytest.raises(RefusedError) as caught:
        open_classifier(folder)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_other_weights_with_a_forged_checksum_are_refused(folder):
    model = onnx.load(str(folder / "model.onnx"))
    linear = next(t for t in model.graph.initializer if t.name == "linear")
    linear.CopyFrom(numpy_helper.from_array(numpy_helper.to_array(linear) * np.float32(1.2), "linear"))
    onnx.save(model, str(folder / "model.onnx"))
    forged = network_sha(folder / "model.onnx")
    edit_manifest(folder, lambda table: table["sha256"].update({"model.onnx": forged}))
    assert "golden" in refuse(folder)


def network_sha(path):
    import hashlib

    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    "changes",
    [
        {"size": 40},
        {"fit": "squash"},
        {"filter": "linear"},
        {"fit": "shorter-side+centre", "crop_fraction": 0.875},
        {"mean": [0.5, 0.5, 0.5]},
        {"std": [0.225, 0.224, 0.229]},
    ],
)
def test_another_preprocessing_than_the_models_is_refused(folder, changes):
    edit_manifest(folder, lambda table: table["input"].update(changes))
    assert "golden" in refuse(folder)


def test_outputs_taken_for_probabilities_are_refused(folder):
    edit_manifest(folder, lambda table: table["output"].update(softmax=False))
    assert "on cpu: expected probabilities, as softmax is off, got -" in refuse(folder)


def test_outputs_taken_for_probabilities_are_refused_of_a_bare_model(tmp_path):
    network = save_tiny(tmp_path / "tiny.onnx").read_bytes()
    with pytest.raises(RefusedError, match="tiny on cpu: expected probabilities, as softmax is off, got"):
        Classifier(network, "tiny", LABELS, SMALL, softmax=False)


def test_an_output_that_is_not_there_is_refused(folder):
    edit_manifest(folder, lambda table: table["output"].update(name="logits"))
    assert "expected an output logits, got y" in refuse(folder)


def test_the_cpu_is_reported_and_is_no_stand_in_when_nothing_else_is_asked_for(classifier):
    assert (classifier.provider, classifier.provider_note) == ("cpu", "")


def test_asked_for_cuda_and_got_the_cpu_is_said_aloud(folder, caplog, monkeypatch):
    with_gpu(monkeypatch, available=["CPUExecutionProvider"])
    opened = open_classifier(folder, options=RuntimeOptions(provider="cuda"))
    assert opened.provider == "cpu"
    assert opened.provider_note.startswith("asked for cuda, got cpu: onnxruntime")
    assert opened.provider_note in caplog.text


def test_required_cuda_is_refused_where_the_runtime_has_none(folder, monkeypatch):
    with_gpu(monkeypatch, available=["CPUExecutionProvider"])
    with pytest.raises(RefusedError, match="require: expected cuda, got a runtime without it"):
        open_classifier(folder, options=RuntimeOptions(require="cuda"))


def test_the_best_provider_is_taken_and_reported(folder, monkeypatch):
    every = [*FakeGpuRuntime().available, "TensorrtExecutionProvider"]
    with_gpu(monkeypatch, available=every)
    assert open_classifier(folder).provider == "tensorrt"
    assert open_classifier(folder, options=RuntimeOptions(provider="cuda")).provider == "cuda"
    assert open_classifier(folder, options=RuntimeOptions(require="cpu")).provider == "cpu"


def test_a_gpu_that_is_gone_at_start_is_replaced_and_named(classifier, folder, monkeypatch, caplog):
    with_gpu(monkeypatch, starts=False)
    opened = open_classifier(folder)
    assert opened.provider == "cpu"
    reason = "CUDA failure 100: no CUDA-capable device is detected"
    assert opened.provider_note == f"cuda is not usable ({reason}): cpu"
    assert opened.provider_note in caplog.text
    np.testing.assert_allclose(opened.probabilities(IMAGE, BOXES), classifier.probabilities(IMAGE, BOXES), atol=1e-3)


def test_a_required_gpu_that_is_gone_at_start_is_refused(folder, monkeypatch):
    with_gpu(monkeypatch, starts=False)
    with pytest.raises(RefusedError, match="no CUDA-capable device"):
        open_classifier(folder, options=RuntimeOptions(require="cuda"))


@pytest.mark.parametrize("runs", [0, 1, 2])
def test_a_gpu_that_fails_while_running_loses_no_box(classifier, folder, monkeypatch, caplog, runs):
    expected = classifier.probabilities(IMAGE, BOXES)
    with_gpu(monkeypatch, runs=runs)
    opened = open_classifier(folder)
    answers = [opened.probabilities(IMAGE, BOXES) for _ in range(3)]
    for answer in answers:
        np.testing.assert_allclose(answer, expected, atol=1e-3)
    assert opened.provider == "cpu"
    assert "cuda failed, cpu has taken over" in opened.provider_note
    assert "unspecified launch failure" in caplog.text


def test_a_required_gpu_that_fails_while_running_raises(folder, monkeypatch):
    with_gpu(monkeypatch, runs=1)
    opened = open_classifier(folder, options=RuntimeOptions(require="cuda"))
    with pytest.raises(RuntimeError, match="cuda failed: CUDA failure 719"):
        opened.probabilities(IMAGE, BOXES)


@pytest.mark.parametrize(
    "options",
    [
        {"provider": "gpu"},
        {"require": "gpu"},
        {"threads": -1},
        {"threads": 1025},
        {"threads": 99999999999},
        {"provider": "cpu", "require": "cuda"},
    ],
)
def test_impossible_runtime_options_are_refused(options):
    with pytest.raises(RefusedError, match=r": expected .*, got "):
        RuntimeOptions(**options)


@pytest.mark.parametrize("options", [{"threads": 1}, {"threads": 2, "spinning": True}])
def test_threads_and_spinning_change_no_answer(classifier, folder, options):
    opened = open_classifier(folder, options=RuntimeOptions(**options))
    np.testing.assert_allclose(opened.probabilities(IMAGE, BOXES), classifier.probabilities(IMAGE, BOXES), atol=1e-6)


def test_a_missing_runtime_is_refused_with_what_installs_it(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(RefusedError, match=r"pip install 'edgefusion\[cpu\]'"):
        open_classifier(folder)
    load_model_folder(folder)  # reading one needs no runtime


MODES = {
    "rc224": (224, "shorter-side+centre", 0.875),
    "squash256": (256, "squash", 1.0),
    "squash224": (224, "squash", 1.0),
}


REAL_MODELS = [
    "mobilenetv2_int8_qdq",
    "squeezenet1_1_int8_qdq",
    "mobilenetv2_fp32_dequant",
    "squeezenet1_1_fp32",
]


def real_classifiers(shared_data, name):
    """A real model with each preprocessing of which answers are on file, and those: picture -> its top 5."""
    expected = json.loads((shared_data / "models" / "golden_top5.json").read_text())["results"][name]
    model = (shared_data / "models" / f"{name}.onnx").read_bytes()
    labels = read_labels(shared_data / "models" / "imagenet_classes.txt")
    for mode in next(iter(expected.values())):
        size, fit, fraction = MODES[mode]
        preprocessing = Preprocessing(
            size=size, fit=fit, filter="linear", mean=IMAGENET_MEAN, std=IMAGENET_STD, crop_fraction=fraction
        )
        yield Classifier(model, name, labels, preprocessing), {p: a[mode] for p, a in expected.items()}


def squashed_by_opencv(image, size):
    rgb = cv2.resize(image, (size, size), interpolation=cv2.INTER_LINEAR)[..., ::-1].astype(np.float32) / 255
    return ((rgb - np.float32(IMAGENET_MEAN)) / np.float32(IMAGENET_STD)).transpose(2, 0, 1)[None].copy()


@pytest.mark.parametrize("name", REAL_MODELS)
def test_real_models_load_quietly_and_answer_the_same_pixels_as_expected(shared_data, name, capfd):
    for opened, answers in real_classifiers(shared_data, name):
        if opened.preprocessing.fit != "squash":
            continue
        for picture, ((first, _, its), (_, _, next_best), *_) in answers.items():
            image = cv2.imread(str(shared_data / picture))
            got = opened.infer(squashed_by_opencv(image, opened.preprocessing.size))[0]
            assert got.argmax() == first or its - next_best < 0.05, picture
            assert got[first] == pytest.approx(its, abs=0.05), picture
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", REAL_MODELS)
def test_real_models_name_real_pictures_as_expected(shared_data, name):
    for opened, answers in real_classifiers(shared_data, name):
        images = {picture: cv2.imread(str(shared_data / picture)) for picture in answers}
        rows = {picture: opened.probabilities(image, whole(image))[0] for picture, image in images.items()}
        same = [rows[picture].argmax() == answers[picture][0][0] for picture in answers]
        # OpenCV rounds to whole grey levels: that alone turns over up to 3 of an int8 model's 12 answers.
        assert sum(same) >= 9, opened.preprocessing


def test_real_int8_model_makes_a_folder_and_passes_its_own_check(shared_data, tmp_path):
    made = make_model_folder(
        shared_data / "models" / "squeezenet1_1_int8_qdq.onnx",
        read_labels(shared_data / "models" / "imagenet_classes.txt"),
        tmp_path / "squeezenet",
        name="squeezenet",
        origin="a test",
        licence="BSD",
    )
    assert (made.manifest.precision, made.golden.tolerance) == ("int8", 2e-2)
    assert open_classifier(made.path).golden_difference <= 2e-2
