# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import argparse
import json
import subprocess
import sys

import pytest

from edgefusion.errors import RefusedError
from edgefusion.tools import model as model_tool
from make_onnx import LABELS, save_labels, save_tiny


def run(*arguments):
    """What `edgefusion model ...` does."""
    parser = argparse.ArgumentParser()
    model_tool.add_parser(parser.add_subparsers())
    args = parser.parse_args(["model", *map(str, arguments)])
    return args.run(args)


@pytest.fixture
def source(tmp_path):
    return save_tiny(tmp_path / "tiny.onnx")


@pytest.fixture
def labels(tmp_path):
    return save_labels(tmp_path / "labels.txt")


@pytest.fixture
def folder(source, labels, tmp_path, capsys):
    assert run("add", source, "--labels", labels, "--size", 32, "--out", tmp_path / "out") == 0
    capsys.readouterr()
    return tmp_path / "out"


def test_add_makes_a_folder_that_check_accepts(folder, capsys):
    assert run("check", folder) == 0
    shown = capsys.readouterr().out
    assert "nothing was changed, 5 labels" in shown
    assert "golden answer on cpu: " in shown


def test_add_names_the_folder_after_the_file(source, labels, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("add", source, "--labels", labels, "--size", 32) == 0
    assert (tmp_path / "tiny" / "manifest.toml").is_file()


def test_add_takes_the_size_that_the_network_is_fixed_to(labels, tmp_path, capsys):
    source = save_tiny(tmp_path / "fixed.onnx", size=48)
    run("add", source, "--labels", labels, "--out", tmp_path / "out")
    assert "48 x 48, letterbox, antialias" in capsys.readouterr().out


def test_add_takes_torchvisions_fraction_with_torchvisions_fit(source, labels, tmp_path):
    options = ("--size", 32, "--fit", "shorter-side+centre", "--filter", "linear", "--out", tmp_path / "out")
    run("add", source, "--labels", labels, *options)
    assert "crop_fraction = 0.875" in (tmp_path / "out" / "manifest.toml").read_text()


def test_add_keeps_what_it_is_told(source, labels, tmp_path, capsys):
    said = {"--name": "mine", "--origin": "a shop", "--licence": "MIT", "--precision": "fp16"}
    options = [text for pair in said.items() for text in pair]
    run("add", source, "--labels", labels, "--size", 32, *options, "--softmax", "--out", tmp_path / "out")
    capsys.readouterr()
    run("show", "--json", tmp_path / "out")
    shown = json.loads(capsys.readouterr().out)
    assert [shown[key] for key in ("name", "origin", "licence", "precision")] == list(said.values())
    assert shown["output"]["softmax"] is True


@pytest.mark.parametrize(("option", "is_softmax"), [("--softmax", True), ("--no-softmax", False)])
def test_add_refuses_a_softmax_that_the_outputs_contradict(labels, tmp_path, option, is_softmax):
    source = save_tiny(tmp_path / "tiny.onnx", softmax=is_softmax)
    with pytest.raises(RefusedError, match=r"tiny\.onnx: expected .* softmax"):
        run("add", source, "--labels", labels, "--size", 32, option, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_add_refuses_labels_that_do_not_fit_and_makes_nothing(source, tmp_path):
    labels = save_labels(tmp_path / "few.txt", LABELS[:2])
    with pytest.raises(RefusedError, match="5 outputs, got 2 labels"):
        run("add", source, "--labels", labels, "--size", 32, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_add_refuses_a_file_that_is_not_there(labels, tmp_path):
    with pytest.raises(RefusedError, match=r"absent\.onnx: expected a file, got nothing"):
        run("add", tmp_path / "absent.onnx", "--labels", labels)


def test_add_refuses_a_network_that_runs_at_another_size_only_and_takes_that(labels, tmp_path):
    source = save_tiny(tmp_path / "vgg.onnx", only_size=48)
    with pytest.raises(RefusedError, match=r"vgg\.onnx: expected a network that runs at 256 x 256, got: .*--size may"):
        run("add", source, "--labels", labels, "--out", tmp_path / "out")
    assert run("add", source, "--labels", labels, "--size", 48, "--out", tmp_path / "out") == 0


def test_add_refuses_a_size_that_no_memory_holds(source, labels, tmp_path):
    with pytest.raises(RefusedError, match="size: expected 1 to 4096 pixels, got 100000"):
        run("add", source, "--labels", labels, "--size", 100000, "--out", tmp_path / "out")


def test_check_refuses_a_changed_folder(folder):
    with (folder / "labels.txt").open("a") as file:
        file.write("one more\n")
    with pytest.raises(RefusedError, match="the file was changed"):
        run("check", folder)


def test_show_is_readable_by_people_and_programs(folder, capsys):
    assert run("show", folder) == 0
    assert "opset 13, IR version 7" in capsys.readouterr().out
    assert run("show", folder, "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["labels"] == list(LABELS)
    assert shown["sha256"].keys() == {"model.onnx", "labels.txt", "golden.png"}


@pytest.mark.parametrize("arguments", [("--help",), ("add", "--help")])
def test_help_gives_examples_and_exit_codes(capsys, arguments):
    with pytest.raises(SystemExit) as stopped:
        run(*arguments)
    assert stopped.value.code == 0
    shown = capsys.readouterr().out
    assert "edgefusion model add mobilenet.onnx" in shown
    assert "Exit status: 0 done, 2 refused" in shown


def test_the_choices_are_those_of_the_preprocessing():
    from typing import get_args

    from edgefusion.perception.onnx_header import Precision
    from edgefusion.perception.preprocessing import Filter, Fit

    assert (get_args(Fit), get_args(Filter)) == (model_tool.FITS, model_tool.FILTERS)
    assert get_args(Precision) == model_tool.PRECISIONS


def test_the_verb_is_registered_without_loading_what_is_heavy():
    program = (
        "import argparse, sys; from edgefusion.tools import model;"
        "model.add_parser(argparse.ArgumentParser().add_subparsers());"
        "sys.exit(str({'numpy', 'cv2', 'onnxruntime', 'msgspec'} & set(sys.modules) or ''))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert result.stderr.strip() == ""
