# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion evaluate` as a user runs it: figures, tables and plots of a few frames."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

pytest.importorskip("panda3d", reason="the camera needs Panda3D (the extra 'sim')")
pytest.importorskip("matplotlib", reason="the plots need matplotlib (the extra 'sim')")


def evaluate(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "edgefusion.cli", "evaluate", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("evaluation") / "results"
    done = evaluate("--frames", 8, "--out", out, "--seed", 4)
    assert done.returncode == 0, done.stderr
    return out


def test_it_leaves_figures_tables_and_plots(results: Path) -> None:
    report = json.loads((results / "figures.json").read_text(encoding="utf-8"))
    assert report["frames"] == 8
    assert set(report["settings"]) == {"edgefusion", "the paper's settings"}
    for plot in ("range.png", "errors.png", "confusion.png"):
        assert cv2.imread(str(results / plot)).shape[1] > 300
    assert "free-standing, edgefusion" in (results / "figures.md").read_text(encoding="utf-8")


def test_both_settings_are_measured_on_the_same_objects(results: Path) -> None:
    settings = json.loads((results / "figures.json").read_text(encoding="utf-8"))["settings"]
    ours, papers = settings["edgefusion"], settings["the paper's settings"]
    for group in ("all", "free", "touching"):
        assert ours[group]["objects"] == papers[group]["objects"]
    assert ours["all"]["objects"] >= 8
    assert papers["precision"]["detections"] <= 8  # the nearest only


def test_kinds_and_ranges_add_up_to_the_free_standing(results: Path) -> None:
    for setting in json.loads((results / "figures.json").read_text(encoding="utf-8"))["settings"].values():
        for key in ("by_kind", "by_range"):
            assert sum(row["objects"] for row in setting[key].values()) == setting["free"]["objects"]


def test_the_same_seed_gives_the_same_figures(results: Path, tmp_path: Path) -> None:
    done = evaluate("--frames", 8, "--out", tmp_path / "again", "--seed", 4, "--json")
    assert done.returncode == 0, done.stderr
    again = json.loads(done.stdout)
    assert again["settings"] == json.loads((results / "figures.json").read_text(encoding="utf-8"))["settings"]


def test_shipped_worlds_are_taken_by_name_and_old_results_go_only_where_asked(tmp_path: Path) -> None:
    (tmp_path / "figures.json").write_text("{}", encoding="utf-8")
    refused = evaluate("--frames", 2, "--out", tmp_path)
    assert refused.returncode == 2
    assert "exists already" in refused.stderr
    done = evaluate("--worlds", "laboratory", "random", "--frames", 6, "--out", tmp_path, "--overwrite", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["worlds"] == ["laboratory", "random"]
    assert json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))["frames"] == 6


EMPTY = """
version = 1
name = "empty"
description = "nothing to look at"
seed = 1
floor = "tiles"
start = [0, 0, 0]
goal = [1, 0, 0]
"""


def test_a_world_with_nothing_to_look_at_is_refused_rather_than_waited_for(tmp_path: Path) -> None:
    (tmp_path / "empty.toml").write_text(EMPTY, encoding="utf-8")
    done = evaluate("--worlds", tmp_path / "empty.toml", "--frames", 2, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "expected an object that can be looked at" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--worlds", "nowhere"), "nowhere"),
        (("--frames", "0"), "expected a whole number from 1 to 1000000, got '0'"),
        (("--model", "nothing-there"), "nothing-there"),
        (("--seed", "-1"), "expected a whole number from 0"),
    ],
)
def test_bad_input_is_refused_with_2_by_name(arguments, message: str, tmp_path: Path) -> None:
    done = evaluate("--out", tmp_path / "out", *arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert not (tmp_path / "out").exists()
