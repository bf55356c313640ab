# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion detect` as a user runs it: real processes, their files and exit codes."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from edgefusion.cli import main
from edgefusion.errors import RefusedError
from edgefusion.tools.results import ResultsFolder, free_folder
from edgefusion.types import ClassScore, Cluster, Detection, Vote
from make_colour_network import save_colour_network
from scene import FRAMES, OBJECTS, nearest_m, write_recording

FIELDS = {
    "frame", "stamp_ns", "label", "group", "score", "margin", "box", "distance_m", "distance_sigma_m", "bearing",
    "scan_frame_dt_ns", "top5",
}  # fmt: skip

DETECTION = Detection(
    stamp_ns=7, class_index=1, label="post", group="", score=0.9, margin=0.8, box=(1, 2, 3, 4), distance_m=1.5,
    distance_sigma_m=0.01, bearing=0.1, position_m=(1.5, 0.1),
    vote=Vote((ClassScore(1, "post", 0.9),), 0, 0.8, ((ClassScore(1, "post", 0.9),),)),
    boxes=((1, 2, 3, 4),), cluster=Cluster(np.arange(3), 1.5, 0.1, 0.2), scan_frame_dt_ns=0,
)  # fmt: skip


def edgefusion(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "edgefusion.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False)


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> list[object]:
    path = save_colour_network(tmp_path_factory.mktemp("network"), {s.name: s.color for s in OBJECTS})
    return ["--model", path, "--labels", path.parent / "labels.txt"]


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    return write_recording(tmp_path / "drive")


def lines_of(out: Path) -> list[dict]:
    return [json.loads(line) for line in (out / "detections.jsonl").read_text(encoding="utf-8").splitlines()]


def test_every_detection_is_a_line_and_the_summary_counts_them(drive: Path, model, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = edgefusion("detect", drive, *model, "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    lines = lines_of(out)
    assert FIELDS <= set(lines[0])
    assert {line["frame"] for line in lines} == set(range(FRAMES))
    summary = json.loads(done.stdout)
    assert summary == json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert (summary["frames"], summary["detections"]) == (FRAMES, len(lines))
    assert summary["sync"] == {"frame paired": FRAMES, "scan paired": FRAMES}
    assert {"cluster", "crop", "infer", "vote", "whole_frame"} <= set(summary["median_ms"])
    post = next(line for line in lines if line["label"] == "post")
    assert post["distance_m"] == pytest.approx(nearest_m(OBJECTS[3], 0.0), abs=0.04)


def test_objects_one_is_the_paper(drive: Path, model, tmp_path: Path) -> None:
    edgefusion("detect", drive, *model, "--out", tmp_path / "out", "--objects", 1)
    assert [line["frame"] for line in lines_of(tmp_path / "out")] == list(range(FRAMES))


def test_one_asks_for_a_label_or_a_group_and_gets_only_that(drive: Path, model, tmp_path: Path) -> None:
    groups = tmp_path / "groups.toml"
    groups.write_text('version = 1\n[groups]\nfurniture = ["cabinet", "sofa"]\n', encoding="utf-8")
    out = tmp_path / "out"
    edgefusion("detect", drive, *model, "--out", out, "--groups", groups, "--find", "furniture", "--find", "post")
    assert {(line["label"], line["group"]) for line in lines_of(out)} == {("cabinet", "furniture"), ("post", "")}


def test_a_name_that_the_model_cannot_answer_is_refused_with_the_nearest(drive: Path, model, tmp_path: Path) -> None:
    done = edgefusion("detect", drive, *model, "--out", tmp_path / "out", "--find", "crates")
    assert done.returncode == 2
    assert "'crates': no label or group of the model; did you mean crate?" in done.stderr


def test_pictures_come_on_request_and_are_of_the_images_size(drive: Path, model, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert edgefusion("detect", drive, *model, "--out", out).returncode == 0
    assert not (out / "annotated").exists()
    assert edgefusion("detect", drive, *model, "--out", out, "--images", "--overwrite").returncode == 0
    assert cv2.imread(str(out / "annotated" / "000005.jpg")).shape == (480, 640, 3)
    assert len(list((out / "scans").glob("*.png"))) == FRAMES


def test_results_are_never_written_over_unasked(drive: Path, model, tmp_path: Path) -> None:
    out = tmp_path / "out"
    edgefusion("detect", drive, *model, "--out", out)
    before = (out / "detections.jsonl").read_bytes()
    again = edgefusion("detect", drive, *model, "--out", out)
    assert again.returncode == 2
    assert "exists already" in again.stderr
    assert (out / "detections.jsonl").read_bytes() == before


def test_a_frame_that_cannot_be_read_ends_the_run_but_keeps_what_was_written(drive: Path, model, tmp_path) -> None:
    path = drive / "images" / "000003.jpg"
    path.write_bytes(path.read_bytes()[:-100])
    done = edgefusion("detect", drive, *model, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert f"{path}: truncated" in done.stderr
    assert {line["frame"] for line in lines_of(tmp_path / "out")} == {0, 1, 2}


@pytest.mark.parametrize(
    ("break_it", "named"),
    [
        (lambda drive: (drive / "images" / "000001.jpg").unlink(), "images/000001.jpg: missing"),
        (lambda drive: (drive / "scans.npz").write_bytes(b"PK"), "scans.npz"),
        (
            lambda drive: (drive / "calibration.toml").write_text("version = 1\n", encoding="utf-8"),
            "calibration.toml",
        ),
        (
            lambda drive: (drive / "calibration.toml").unlink(),
            "expected calibration.toml or calibration.json",
        ),
        (lambda drive: shutil.rmtree(drive), "expected a folder"),
    ],
    ids=["image", "scans", "calibration", "no calibration", "no recording"],
)
def test_bad_input_is_refused_in_one_line_that_names_it(drive: Path, model, tmp_path: Path, break_it, named) -> None:
    break_it(drive)
    done = edgefusion("detect", drive, *model, "--out", tmp_path / "out")
    assert done.returncode == 2
    (line,) = [line for line in done.stderr.splitlines() if "nothing vouches" not in line]
    assert line.startswith("edgefusion: ")
    assert named in line
    assert not (tmp_path / "out" / "detections.jsonl").exists()


def test_an_image_of_another_size_than_the_calibrations_is_named(drive: Path, model, tmp_path: Path) -> None:
    path = drive / "images" / "000002.jpg"
    cv2.imwrite(str(path), cv2.imread(str(path))[:240])
    done = edgefusion("detect", drive, *model, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert f"{path}: the calibration is for 640x480, the image is 640x240" in done.stderr


def test_latencies_pair_what_was_captured_together(drive: Path, model, tmp_path: Path) -> None:
    """The camera's stamps are 0.2 s late: frame N + 1 belongs to scan N."""
    with (drive / "calibration.toml").open("a", encoding="utf-8") as file:
        file.write("camera_latency_ns = 200000000\n")
    assert edgefusion("detect", drive, *model, "--out", tmp_path / "out").returncode == 0
    lines = lines_of(tmp_path / "out")
    assert {line["frame"] for line in lines} == set(range(1, FRAMES))
    assert {line["scan_frame_dt_ns"] for line in lines} == {0}


def test_the_lasers_latency_counts_against_the_cameras(drive: Path, model, tmp_path: Path) -> None:
    """The laser's stamps are 0.2 s late: frame N belongs to scan N + 1."""
    with (drive / "calibration.toml").open("a", encoding="utf-8") as file:
        file.write("laser_latency_ns = 200000000\n")
    assert edgefusion("detect", drive, *model, "--out", tmp_path / "out").returncode == 0
    lines = lines_of(tmp_path / "out")
    assert {line["frame"] for line in lines} == set(range(FRAMES - 1))
    assert {line["scan_frame_dt_ns"] for line in lines} == {0}
    with np.load(drive / "scans.npz") as scans:
        second = scans["ranges"][1]
    post = next(line for line in lines if (line["frame"], line["label"]) == (0, "post"))
    assert post["distance_m"] == pytest.approx(second.min(), abs=0.04)


def restamp(drive: Path, image_stamp) -> None:
    with np.load(drive / "scans.npz") as scans:
        content = dict(scans)
    np.savez(drive / "scans.npz", **{**content, "image_stamp": image_stamp})


def test_what_found_no_partner_is_counted(drive: Path, model, tmp_path: Path) -> None:
    restamp(drive, np.arange(FRAMES) * 0.2 + [0, 0, 0, 0, 1, 1])
    done = edgefusion("detect", drive, *model, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    counts = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["sync"]
    assert counts == {"frame paired": 4, "frame without partner": 2, "scan paired": 4, "scan without partner": 2}
    assert "pairing:         frame paired 4, frame without partner 2" in done.stdout


def test_a_recording_without_a_single_pair_is_refused(drive: Path, model, tmp_path: Path) -> None:
    restamp(drive, np.arange(FRAMES) * 0.2 + 5)
    done = edgefusion("detect", drive, *model, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert f"{drive}: no frame within tolerance_s = 0.1 s of a scan: the nearest are 4 s apart" in done.stderr
    assert not (tmp_path / "out" / "summary.json").exists()


def test_overwriting_leaves_nothing_of_the_run_before(drive: Path, model, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert edgefusion("detect", drive, *model, "--out", out, "--images").returncode == 0
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    path = drive / "images" / "000003.jpg"
    path.write_bytes(path.read_bytes()[:-100])
    assert edgefusion("detect", drive, *model, "--out", out, "--overwrite").returncode == 2
    assert sorted(each.name for each in out.iterdir()) == ["detections.jsonl", "notes.txt"]
    assert {line["frame"] for line in lines_of(out)} == {0, 1, 2}


def test_overwrite_without_out_replaces_the_results_in_the_usual_place(drive: Path, model, tmp_path: Path) -> None:
    for _ in range(2):
        done = edgefusion("detect", drive, *model, "--overwrite", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["drive"]


def test_a_run_refused_before_its_first_frame_leaves_no_trace(drive: Path, model, tmp_path: Path) -> None:
    out, path = tmp_path / "out", drive / "images" / "000000.jpg"
    whole = path.read_bytes()
    path.write_bytes(whole[:-100])
    assert edgefusion("detect", drive, *model, "--out", out).returncode == 2
    assert not out.exists()
    path.write_bytes(whole)
    assert edgefusion("detect", drive, *model, "--out", out).returncode == 0
    path.write_bytes(whole[:-100])
    before = (out / "detections.jsonl").read_bytes()
    assert edgefusion("detect", drive, *model, "--out", out, "--overwrite").returncode == 2
    assert (out / "detections.jsonl").read_bytes() == before


def full_disk(out: Path) -> None:
    (out / "detections.jsonl").symlink_to("/dev/full")


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (full_disk, "detections.jsonl: cannot write there: No space left on device"),
        (lambda out: (out / "annotated").touch(), "annotated: cannot write there"),
        (lambda out: (out / "summary.json").mkdir(), "summary.json: cannot write there: Is a directory"),
        (lambda out: (out.rmdir(), out.touch()), "out: cannot write there"),
    ],
    ids=["full disk", "annotated is a file", "summary is a folder", "out is a file"],
)
def test_what_cannot_be_written_is_refused_by_name(tmp_path: Path, spoil, named: str) -> None:
    out = tmp_path / "out"
    out.mkdir()
    spoil(out)
    with pytest.raises(RefusedError, match=named), ResultsFolder(out, overwrite=True) as results:
        for frame in range(2):
            results.write_detections(frame, [DETECTION])
            results.write_image(f"annotated/{frame}.png", np.zeros((4, 4, 3), np.uint8))
        results.write_summary({"frames": 2})


def test_a_folder_that_the_system_will_not_look_into_is_refused(tmp_path: Path) -> None:
    for look in (lambda path: ResultsFolder(path), lambda path: free_folder(path, "drive")):
        with pytest.raises(RefusedError, match="cannot write there: File name too long"):
            look(tmp_path / ("o" * 300))


def test_a_reader_that_leaves_early_is_no_error() -> None:
    for arguments in (["--help"], ["detect", "--help"]):
        process = subprocess.Popen(
            [sys.executable, "-m", "edgefusion.cli", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        process.stderr.close()
        assert process.wait() == 0


def test_a_full_disk_behind_stdout_is_one_line(drive: Path, model, tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "edgefusion.cli", "detect", drive, *model, "--out", tmp_path / "out"],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "edgefusion: [Errno 28] No space left on device"


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (RuntimeError("CUDA failed\nbadly"), 1, "edgefusion: CUDA failed badly\n"),
        (KeyboardInterrupt(), 130, "edgefusion: interrupted\n"),
        (RefusedError("x.toml: no"), 2, "edgefusion: x.toml: no\n"),
    ],
)
def test_what_ends_a_run_early_has_its_own_exit_code_and_one_line(monkeypatch, capsys, error, code, line) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("edgefusion.tools.demo.run", fail)
    assert main(["demo"]) == code
    assert capsys.readouterr().err == line
    monkeypatch.setattr("edgefusion.cli.build_parser", fail)  # while modules are loaded
    assert main(["demo"]) == code


def test_every_exit_code_is_in_the_help() -> None:
    for verb in ("detect", "demo"):
        shown = edgefusion(verb, "--help").stdout
        assert "Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted" in shown


@pytest.mark.parametrize("number", ["x", "0", "-1", "2.5", "101"])
def test_a_number_of_objects_that_cannot_be_is_refused_in_words(capsys, number: str) -> None:
    with pytest.raises(SystemExit):
        main(["detect", "drive", "--model", "m", f"--objects={number}"])
    assert f"argument --objects: expected a whole number from 1 to 100, got '{number}'" in capsys.readouterr().err
