# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import contextlib
import io
import json
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import cv2
import msgspec
import numpy as np
import onnx
import pytest
from onnx import numpy_helper

from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import load_model_folder
from edgefusion.perception.network import Network, RuntimeOptions
from edgefusion.perception.onnx_header import read_onnx_header
from edgefusion.perception.preprocessing import PAPER
from make_colour_network import save_colour_network
from make_onnx import LABELS, save_tiny, tiny_network

SCRIPT = Path(__file__).resolve().parents[1] / "models" / "finetune.py"
PRIMARY = {"red": (0, 0, 255), "green": (0, 255, 0), "blue": (255, 0, 0)}
MIXED = {"cyan": (220, 220, 30), "grey": (128, 128, 128), "magenta": (220, 30, 220), "yellow": (30, 220, 220)}
SMALL = msgspec.structs.replace(PAPER, size=32)


class Result(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


@contextlib.contextmanager
def beside_the_script():
    sys.path.insert(0, str(SCRIPT.parent))
    try:
        yield
    finally:
        sys.path.remove(str(SCRIPT.parent))


with beside_the_script():
    from linear_head import fit_head, hold_out


def finetune(*arguments):
    """What `python models/finetune.py ...` does. In this process, since importing scikit-learn takes seconds."""
    out, err = io.StringIO(), io.StringIO()
    with beside_the_script(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = runpy.run_path(str(SCRIPT))["main"]([str(argument) for argument in arguments])
    return Result(code, out.getvalue(), err.getvalue())


def made(*arguments):
    result = finetune(*arguments)
    assert result.returncode == 0, result.stderr
    return result


def refusal(*arguments):
    """The one line of a refused call."""
    result = finetune(*arguments)
    assert result.returncode == 2, result.stderr
    line = result.stderr.strip().splitlines()[-1]
    assert "expected" in line
    assert "got" in line
    return line


def picture_of(colour, rng):
    """About the colour, with noise; BGR, not square."""
    return np.clip(rng.normal(colour, 25, (24, 36, 3)), 0, 255).astype(np.uint8)


def save_photos(root, colours, images=10, seed=0):
    """One folder of noisy pictures per colour."""
    rng = np.random.default_rng(seed)
    for label, colour in colours.items():
        (root / label).mkdir(parents=True)
        for number in range(images):
            cv2.imwrite(str(root / label / f"{number}.png"), picture_of(colour, rng))
    return root


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """Photos of mixed colours, a base that knows primary ones, the folder that was made of both, and what was said."""
    folder = tmp_path_factory.mktemp("finetune")
    photos = save_photos(folder / "photos", MIXED)
    base = save_colour_network(folder / "base", PRIMARY)
    return photos, base, folder / "out", made(photos, "--base", base, "--out", folder / "out")


@pytest.fixture
def photos(mixed, tmp_path):
    return shutil.copytree(mixed[0], tmp_path / "photos")


def refused_photos(mixed, photos):
    """The line that refuses a folder of photos."""
    out = photos.parent / "out"
    line = refusal(photos, "--base", mixed[1], "--out", out)
    assert not out.exists()
    return line


def test_the_folder_names_ones_own_classes_which_its_base_does_not_know(mixed):
    classifier = open_classifier(mixed[2])
    assert classifier.labels == tuple(MIXED)
    rng = np.random.default_rng(1)
    for number, colour in enumerate(MIXED.values()):
        image = picture_of(colour, rng)
        (answer,) = classifier.probabilities(image, [(0, 0, 36, 24)])
        assert answer.argmax() == number
        assert answer.sum() == pytest.approx(1)


def test_the_file_is_read_by_the_jetsons_runtime_and_takes_any_number_of_images_of_any_size(mixed):
    content = (mixed[2] / "model.onnx").read_bytes()
    header = read_onnx_header(content)
    assert (header.opset, header.ir_version) == (13, 7)
    network = Network(content, "a test", RuntimeOptions(provider="cpu"))
    for shape in ((1, 3, 40, 40), (3, 3, 20, 20)):
        assert network.run(np.zeros(shape, np.float32)).shape == (shape[0], 4)


def test_what_is_printed_what_the_json_says_and_what_the_manifest_says_are_the_same(mixed, tmp_path):
    photos, base, out, said = mixed
    report = json.loads(made(photos, "--base", base, "--out", tmp_path / "out", "--json").stdout)
    confusion = np.array(report["confusion"])
    assert report["labels"] == list(MIXED)
    assert report["images"] == [10] * 4
    assert confusion.sum(axis=1).tolist() == [2] * 4
    assert report["accuracy"] == np.trace(confusion) / 8
    assert f"{np.trace(confusion)} of 8 images named right" in said.stdout
    assert "other 32" in said.stdout
    rows = [line.split() for line in said.stdout.splitlines() if line.strip()[:1].isdigit()]
    assert [row[2:] for row in rows if row[1] in MIXED] == [[str(n or ".") for n in row] for row in confusion]
    training = load_model_folder(out).manifest.training
    assert training.accuracy == report["accuracy"]
    assert training.command.startswith("python models/finetune.py ")


def test_the_accuracy_is_that_of_images_the_head_was_not_fitted_to():
    """Noise can be learnt by heart, but says nothing about other noise."""
    rng = np.random.default_rng(4)
    features = rng.normal(0, 1, (60, 200)).astype(np.float32)
    classes = np.repeat([0, 1, 2], 20)
    assert (fit_head(features, classes, 100.0).logits(features).argmax(axis=1) == classes).all()
    assert hold_out(features, classes, seed=0).accuracy < 0.8


def test_the_same_seed_gives_the_same_bytes(mixed, tmp_path):
    photos, base, out, _ = mixed
    made(photos, "--base", base, "--out", tmp_path / "out")
    assert (tmp_path / "out" / "model.onnx").read_bytes() == (out / "model.onnx").read_bytes()


def test_the_old_last_layer_is_not_carried_along(photos, tmp_path):
    base = save_tiny(tmp_path / "base.onnx", classes=3000)
    made(photos, "--base", base, "--out", tmp_path / "out")
    assert (tmp_path / "out" / "model.onnx").stat().st_size < 5000 < base.stat().st_size
    graph = onnx.load(str(tmp_path / "out" / "model.onnx")).graph
    read = {name for node in graph.node for name in node.input}
    assert {each.name for each in graph.initializer} <= read


def test_a_model_folder_as_base_passes_on_its_preprocessing_and_licence(photos, tmp_path):
    facts = {"name": "tiny", "origin": "a test", "licence": "MIT", "preprocessing": SMALL}
    make_model_folder(save_tiny(tmp_path / "tiny.onnx"), LABELS, tmp_path / "base", **facts)
    made(photos, "--base", tmp_path / "base", "--out", tmp_path / "out")
    manifest = load_model_folder(tmp_path / "out").manifest
    assert (manifest.input.size, manifest.input.fit, manifest.licence) == (32, "squash", "MIT")
    assert manifest.origin.startswith("tiny (a test)")


def test_what_was_made_is_a_base_for_other_classes(mixed, tmp_path):
    photos = save_photos(tmp_path / "photos", PRIMARY)
    made(photos, "--base", mixed[2], "--out", tmp_path / "out")
    classifier = open_classifier(tmp_path / "out")
    assert classifier.labels == tuple(sorted(PRIMARY))
    image = picture_of(PRIMARY["green"], np.random.default_rng(2))
    assert classifier.labels[classifier.probabilities(image, [(0, 0, 36, 24)]).argmax()] == "green"


def test_two_classes_are_enough(mixed, tmp_path):
    photos = save_photos(tmp_path / "photos", {"dark": (40, 40, 40), "light": (210, 210, 210)}, images=5)
    made(photos, "--base", mixed[1], "--out", tmp_path / "out")
    classifier, rng = open_classifier(tmp_path / "out"), np.random.default_rng(3)
    answers = [classifier.probabilities(picture_of([grey] * 3, rng), [(0, 0, 36, 24)])[0] for grey in (40, 210)]
    assert [answer.argmax() for answer in answers] == [0, 1]


class TestPhotos:
    def test_hidden_files_are_left_out(self, mixed, photos):
        (photos / ".DS_Store").write_bytes(b"x")
        (photos / "cyan" / ".DS_Store").write_bytes(b"x")
        made(photos, "--base", mixed[1], "--out", photos.parent / "out")

    def test_too_few_images_of_a_class_are_refused_with_both_numbers(self, mixed, photos):
        for number in range(6):
            (photos / "grey" / f"{number}.png").unlink()
        line = refused_photos(mixed, photos)
        assert line == f"{photos / 'grey'}: expected 5 images of a class at least, got 4"

    def test_a_single_class_is_refused(self, mixed, photos):
        for label in ("cyan", "grey", "magenta"):
            shutil.rmtree(photos / label)
        line = refused_photos(mixed, photos)
        assert line.endswith("expected two classes at least, a folder of images each, got yellow")

    @pytest.mark.parametrize("name", ["unknown", "two\nlines", " blue"])
    def test_a_name_that_no_label_can_have_is_refused(self, mixed, photos, name):
        (photos / "grey").rename(photos / name)
        assert "expected " in refused_photos(mixed, photos)

    def test_an_image_that_cannot_be_read_is_named(self, mixed, photos):
        (photos / "grey" / "3.png").write_bytes(b"no picture")
        assert f"{photos / 'grey' / '3.png'}: expected a picture" in refused_photos(mixed, photos)

    def test_the_same_image_in_two_classes_is_refused(self, mixed, photos):
        shutil.copy(photos / "grey" / "3.png", photos / "cyan" / "mine.png")
        assert "expected every image once, got a copy of" in refused_photos(mixed, photos)

    def test_what_is_not_in_its_place_is_refused(self, mixed, photos):
        (photos / "grey" / "more").mkdir()
        assert f"{photos / 'grey' / 'more'}: expected an image, got a folder" in refused_photos(mixed, photos)
        (photos / "grey" / "more").rmdir()
        (photos / "notes.txt").write_text("x")
        assert f"{photos / 'notes.txt'}: expected a folder of images" in refused_photos(mixed, photos)

    def test_a_folder_that_is_not_there_is_refused(self, mixed, tmp_path):
        line = refusal(tmp_path / "none", "--base", mixed[1], "--out", tmp_path / "out")
        assert "expected a folder with a folder of images per class, got nothing" in line


def test_an_existing_folder_is_refused_before_any_work(tmp_path):
    assert "not there yet" in refusal(tmp_path / "photos", "--out", tmp_path)


def test_without_a_base_it_says_what_makes_one(mixed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refusal(mixed[0], "--out", tmp_path / "out")
    assert line.startswith("models/resnet18: expected a base")
    assert "models/export.py --out models/resnet18" in line


@pytest.mark.parametrize("module", ["onnx", "sklearn.linear_model"])
def test_without_what_it_needs_it_says_what_to_install(mixed, tmp_path, monkeypatch, module):
    for name in ("onnx_surgery", "linear_head"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, module, None)
    line = refusal(mixed[0], "--base", mixed[1], "--out", tmp_path / "out")
    assert "pip install 'edgefusion[cpu,finetune]'" in line


@pytest.mark.parametrize(("value", "expected"), [(0.0, "features that differ"), (np.nan, "finite numbers")])
def test_a_base_whose_features_say_nothing_is_refused(mixed, tmp_path, value, expected):
    model = tiny_network()
    (conv,) = (each for each in model.graph.initializer if each.name == "conv")
    conv.CopyFrom(numpy_helper.from_array(np.full((8, 3, 3, 3), value, np.float32), "conv"))
    onnx.save(model, str(tmp_path / "base.onnx"))
    assert expected in refusal(mixed[0], "--base", tmp_path / "base.onnx", "--out", tmp_path / "out")


def test_the_script_runs_by_itself_and_its_help_gives_examples():
    result = subprocess.run([sys.executable, SCRIPT, "--help"], capture_output=True, text=True, check=True)
    assert "python models/finetune.py photos --out models/mine" in result.stdout


@pytest.mark.parametrize(
    "name", ["mobilenetv2_fp32_dequant", "mobilenetv2_int8_qdq", "squeezenet1_1_fp32", "squeezenet1_1_int8_qdq"]
)
def test_real_networks_learn_classes_of_their_photographs(shared_data, tmp_path, name):
    """The car ahead and the road's side are no classes of ImageNet; frames far apart are asked for."""
    frames = [cv2.imread(str(shared_data / "kitti-drive" / "images" / f"{i:06d}.jpg")) for i in range(0, 30, 3)]
    truth = json.loads((shared_data / "kitti-drive" / "truth_0_29.json").read_text())
    boxes = [np.array(truth[i]["box"], int) for i in range(0, 30, 3)]
    for label in ("car ahead", "sky", "roadside"):
        (tmp_path / "photos" / label).mkdir(parents=True)
    for i, (frame, (x0, y0, x1, y1)) in enumerate(zip(frames, boxes)):
        parts = {"car ahead": frame[y0:y1, x0:x1], "sky": frame[:130, 500:700], "roadside": frame[150:, :300]}
        for label, part in parts.items():
            cv2.imwrite(str(tmp_path / "photos" / label / f"{i}.png"), part)
    base = shared_data / "models" / f"{name}.onnx"
    report = json.loads(made(tmp_path / "photos", "--base", base, "--out", tmp_path / "out", "--json").stdout)
    assert report["accuracy"] == 1
    content = (tmp_path / "out" / "model.onnx").read_bytes()
    before, after = read_onnx_header(base.read_bytes()), read_onnx_header(content)
    assert (after.opset, after.ir_version, after.precision) == (before.opset, before.ir_version, before.precision)
    assert len(content) < 0.7 * base.stat().st_size
    assert open_classifier(tmp_path / "out").labels == ("car ahead", "roadside", "sky")
