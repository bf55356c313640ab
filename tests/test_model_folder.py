# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import shutil
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import cv2
import msgspec
import numpy as np
import onnx
import pytest

from edgefusion.errors import RefusedError
from edgefusion.perception import make_model
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import load_model_folder, read_labels
from edgefusion.perception.onnx_header import read_onnx_header
from edgefusion.perception.preprocessing import PAPER
from make_onnx import LABELS, edit_manifest, save_labels, save_tiny, tiny_network

SMALL = msgspec.structs.replace(PAPER, size=32)
FILES = ("model.onnx", "labels.txt", "golden.png")


def make(path, onnx_file, labels=LABELS, **options):
    facts = {"name": "tiny", "origin": "a test", "licence": "Apache-2.0", "preprocessing": SMALL}
    return make_model_folder(onnx_file, labels, path, **{**facts, **options})


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    return make(folder / "tiny", save_tiny(folder / "tiny.onnx")).path


@pytest.fixture
def folder(original, tmp_path):
    return shutil.copytree(original, tmp_path / "tiny")


def refusal(path):
    """The one line that refuses a folder."""
    with pytest.raises(RefusedError) as caught:
        load_model_folder(path)
    assert "\n" not in str(caught.value)
    assert "expected" in str(caught.value)
    assert "got" in str(caught.value)
    return str(caught.value)


def test_what_is_made_is_what_is_read(folder):
    read = load_model_folder(folder)
    assert read.labels == LABELS
    assert read.manifest.precision == "fp32"
    assert read.manifest.output.softmax
    assert (read.manifest.input.size, read.manifest.input.fit, read.manifest.input.name) == (
        32,
        "squash",
        "x",
    )
    assert read.manifest.golden.probabilities == sorted(read.manifest.golden.probabilities, reverse=True)
    assert read.golden.tolerance == 1e-3


def test_the_same_model_makes_the_same_folder(folder, tmp_path):
    again = make(tmp_path / "again", folder / "model.onnx")
    assert [(again.path / name).read_bytes() for name in (*FILES, "manifest.toml")] == [
        (folder / name).read_bytes() for name in (*FILES, "manifest.toml")
    ]


@pytest.mark.parametrize("name", FILES)
def test_every_flipped_bit_is_refused(folder, name):
    intact = (folder / name).read_bytes()
    rng = np.random.default_rng(0)
    for offset in {0, len(intact) - 1, *rng.integers(0, len(intact), 300).tolist()}:
        flipped = bytearray(intact)
        flipped[offset] ^= 1 << int(rng.integers(8))
        (folder / name).write_bytes(flipped)
        assert "the file was changed" in refusal(folder)
    (folder / name).write_bytes(intact)
    load_model_folder(folder)


def test_every_flipped_bit_of_the_manifest_is_refused(folder):
    path = folder / "manifest.toml"
    intact = path.read_bytes()
    for bit in range(8 * len(intact)):
        flipped = bytearray(intact)
        flipped[bit // 8] ^= 1 << (bit % 8)
        path.write_bytes(flipped)
        assert str(path) in refusal(folder)
    path.write_bytes(intact)
    load_model_folder(folder)


@pytest.mark.parametrize("forge", [lambda lines: lines[:-1], lambda lines: [*lines, b"# mine\n"]])
def test_a_manifest_that_does_not_end_in_its_seal_is_refused(folder, forge):
    path = folder / "manifest.toml"
    path.write_bytes(b"".join(forge(path.read_bytes().splitlines(keepends=True))))
    assert "expected its own SHA-256 on the last line" in refusal(folder)


@pytest.mark.parametrize("name", [*FILES, "manifest.toml"])
def test_every_truncation_is_refused(folder, name):
    intact = (folder / name).read_bytes()
    for length in {*range(0, len(intact), max(1, len(intact) // 200)), len(intact) - 1}:
        (folder / name).write_bytes(intact[:length])
        assert str(folder / name) in refusal(folder)


@pytest.mark.parametrize("name", [*FILES, "manifest.toml"])
def test_a_missing_file_is_named(folder, name):
    (folder / name).unlink()
    assert refusal(folder) == f"{folder / name}: expected a file, got nothing"


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    assert "got nothing" in refusal(tmp_path / "absent")


def test_an_unknown_key_is_refused_by_name(folder):
    edit_manifest(folder, lambda table: table["input"].update(sise=224))
    assert "`sise`" in refusal(folder)


def test_a_missing_key_is_refused_by_name(folder):
    edit_manifest(folder, lambda table: table["input"].pop("fit"))
    assert "`fit`" in refusal(folder)


def test_an_impossible_value_is_refused(folder):
    edit_manifest(folder, lambda table: table["input"].update(size=0))
    assert "size: expected 1 to 4096 pixels, got 0" in refusal(folder)


def test_a_newer_format_is_refused_as_such(folder):
    edit_manifest(folder, lambda table: table.update(version=2))
    assert "expected version = 1, got 2: made by a newer edgefusion" in refusal(folder)


@pytest.mark.parametrize("text", ["", "version =", 'version = "1"', "version = 1", "\x00"])
def test_a_manifest_that_is_none_is_refused(folder, text):
    (folder / "manifest.toml").write_text(text)
    assert "manifest.toml" in refusal(folder)


def test_golden_classes_beyond_the_labels_are_refused(folder):
    edit_manifest(folder, lambda table: table["golden"]["classes"].__setitem__(0, 5))
    assert "expected golden.classes of 0..4, got 5" in refusal(folder)


@pytest.mark.parametrize("probability", [-0.1, 1.1, 30.0, float("nan"), float("inf")])
def test_golden_probabilities_that_are_none_are_refused(folder, probability):
    edit_manifest(folder, lambda table: table["golden"]["probabilities"].__setitem__(0, probability))
    assert f"golden: expected probabilities of 0..1, got {probability:g}" in refusal(folder)


def test_an_existing_folder_is_never_overwritten(folder):
    before = (folder / "model.onnx").read_bytes()
    with pytest.raises(RefusedError, match="not there yet"):
        make(folder, folder / "model.onnx")
    assert (folder / "model.onnx").read_bytes() == before


def test_a_folder_that_fails_half_way_leaves_nothing_behind(tmp_path, monkeypatch):
    source = save_tiny(tmp_path / "tiny.onnx")

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(make_model.os, "fsync", full_disk)
    with pytest.raises(RefusedError, match="No space left on device"):
        make(tmp_path / "out", source)
    assert list(tmp_path.iterdir()) == [source]


def test_another_number_of_labels_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="expected a label for each of its 5 outputs, got 4 labels"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx"), LABELS[:4])


def test_another_size_than_the_networks_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="expected size = 64, its input's, got 32"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", size=64))


def test_a_network_without_a_clear_answer_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="give a golden picture"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", liveliness=0))


def test_a_network_whose_outputs_are_not_finite_is_refused(tmp_path):
    with pytest.raises(RefusedError, match=r"tiny\.onnx: expected finite outputs"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", liveliness=np.nan))


def test_a_picture_may_be_given_as_the_golden_one(tmp_path):
    picture = np.random.default_rng(1).integers(0, 256, (40, 50, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "mine.png"), picture)
    made = make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx"), golden=tmp_path / "mine.png")
    assert (made.golden.picture == picture).all()


def test_a_golden_picture_that_is_none_is_refused(tmp_path):
    save_labels(tmp_path / "mine.png")
    with pytest.raises(RefusedError, match=r"mine\.png: expected a picture"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx"), golden=tmp_path / "mine.png")


def huge_png(side):
    """The start of a picture that says it is this large."""

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"0"))


def test_a_golden_picture_too_large_for_opencv_is_refused(tmp_path):
    (tmp_path / "mine.png").write_bytes(huge_png(100000))
    with pytest.raises(RefusedError, match=r"mine\.png: expected a picture") as caught:
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx"), golden=tmp_path / "mine.png")
    assert "\n" not in str(caught.value)


def test_a_network_that_does_not_run_at_the_size_is_refused(tmp_path):
    with pytest.raises(RefusedError, match=r"tiny\.onnx: expected a network that runs at 32 x 32, got"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", only_size=64))


def test_a_file_that_must_not_be_read_is_refused(folder, monkeypatch):
    def forbidden(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", forbidden)
    assert "expected a file that can be read, got: Permission denied" in refusal(folder)


def test_whether_a_softmax_is_needed_is_found_out(tmp_path):
    made = make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", softmax=True))
    assert not made.manifest.output.softmax


@pytest.mark.parametrize("half", [False, True])
def test_probabilities_may_be_said_to_be_some(tmp_path, half):
    made = make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", softmax=True, half=half), softmax=False)
    assert not made.manifest.output.softmax


def test_outputs_said_to_be_probabilities_are_refused(tmp_path):
    with pytest.raises(RefusedError, match=r"tiny\.onnx: expected probabilities, as softmax is off, got .* a sum of"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx"), softmax=False)


def test_a_softmax_of_probabilities_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="expected outputs that need a softmax, got probabilities"):
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", softmax=True), softmax=True)


def test_half_precision_is_found_out_and_compared_less_strictly(tmp_path):
    made = make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", half=True))
    assert (made.manifest.precision, made.golden.tolerance) == ("fp16", 2e-2)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"opset": 99}, "expected an opset up to .*, all that onnxruntime .* reads, got opset 99"),
        ({"ir_version": 99}, "expected an IR version up to .*, got opset 13, IR version 99"),
        ({"input_type": onnx.TensorProto.DOUBLE}, "tensor"),
        ({"outputs": ("y", "z")}, "expected one output, or the name of one of them, got y, z"),
    ],
)
def test_a_network_that_will_not_do_is_refused_with_the_reason(tmp_path, options, expected):
    with pytest.raises(RefusedError, match=expected) as caught:
        make(tmp_path / "out", save_tiny(tmp_path / "tiny.onnx", **options))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_network_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="expected an ONNX model, got"):
        make(tmp_path / "out", save_labels(tmp_path / "labels.txt"))


def test_weights_in_another_file_are_refused(tmp_path):
    network = tiny_network()
    path = str(tmp_path / "tiny.onnx")
    onnx.save(network, path, save_as_external_data=True, location="weights", size_threshold=0)
    with pytest.raises(RefusedError, match="expected all weights in this one file"):
        make(tmp_path / "out", tmp_path / "tiny.onnx")


def test_labels_may_repeat_and_keep_their_order(tmp_path):
    assert read_labels(save_labels(tmp_path / "labels.txt")) == LABELS


def test_labels_of_a_windows_editor_are_read(tmp_path):
    (tmp_path / "labels.txt").write_bytes(b"\xef\xbb\xbfcup\r\nplant pot \r\n\r\n")
    assert read_labels(tmp_path / "labels.txt") == ("cup", "plant pot")


@pytest.mark.parametrize("content", [b"", b"\n", b"cup\n\nplant\n", b"\xff\xfe\x00"])
def test_labels_that_are_none_are_refused(tmp_path, content):
    (tmp_path / "labels.txt").write_bytes(content)
    with pytest.raises(RefusedError, match=r"labels\.txt: expected"):
        read_labels(tmp_path / "labels.txt")


def test_a_label_that_means_no_label_is_refused(tmp_path):
    labels = save_labels(tmp_path / "labels.txt", ["cup", "unknown"])
    with pytest.raises(RefusedError, match=r"labels\.txt: expected labels other than unknown, .*, got it on line 2"):
        read_labels(labels)


def test_a_truncated_network_is_never_taken_for_a_whole_one():
    network = tiny_network().SerializeToString()
    graph_ends = max(i for i in range(len(network)) if read_or_none(network[:i]) is None)
    assert read_onnx_header(network).opset == 13
    assert graph_ends > 0.9 * len(network)


def read_or_none(content):
    try:
        return read_onnx_header(content)
    except ValueError:
        return None


def test_reading_a_folder_needs_nothing_that_only_making_one_does():
    program = (
        "import sys; from edgefusion.perception import classifier;"
        "sys.exit(str({'tomli_w', 'edgefusion.perception.make_model'} & set(sys.modules) or ''))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert result.stderr.strip() == ""
