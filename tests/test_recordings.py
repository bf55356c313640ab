# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One door to recordings of every kind; what is behind it goes through the detector, always with the same result."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bag_scenes import KINDS, OFFSET_NS, samples, write_ours, written_as
from edgefusion.cli import main
from edgefusion.errors import RefusedError
from edgefusion.recording.carmen_recording import CarmenRecording
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.recording import open_recording
from edgefusion.types import Scan
from make_colour_network import save_colour_network
from scene import FRAMES, OBJECTS, write_recording

LINE = "FLASER 181 " + " ".join(["2.5"] * 181) + " 0 0 0 0 0 0 976052857 host 0.1\n"


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("recordings") / "drive")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    path = save_colour_network(tmp_path_factory.mktemp("network"), {s.name: s.color for s in OBJECTS})
    return ["--model", str(path), "--labels", str(path.parent / "labels.txt")]


def detections(path: Path, model: list[str], out: Path, *more: str) -> list[dict]:
    assert main(["detect", str(path), *model, "--out", str(out), *more]) == 0
    return [json.loads(line) for line in (out / "detections.jsonl").read_text(encoding="utf-8").splitlines()]


@pytest.mark.parametrize("kind", KINDS)
def test_detect_finds_in_a_bag_what_it_finds_in_the_folder(
    drive: Path, model: list[str], tmp_path: Path, kind: str
) -> None:
    expected = detections(drive, model, tmp_path / "folder")
    found = detections(written_as(kind, tmp_path, samples(drive)), model, tmp_path / "bag")
    assert {line["frame"] for line in found} == set(range(FRAMES))
    assert [(line["frame"], line["label"], line["stamp_ns"] - OFFSET_NS) for line in found] == [
        (line["frame"], line["label"], line["stamp_ns"]) for line in expected
    ]
    assert [line["distance_m"] for line in found] == pytest.approx([line["distance_m"] for line in expected], abs=1e-4)


def test_the_same_bag_gives_the_same_bytes_twice(drive: Path, model: list[str], tmp_path: Path) -> None:
    path = write_ours(tmp_path / "a.mcap", samples(drive))
    for out in ("one", "two"):
        detections(path, model, tmp_path / out)
    one, two = ((tmp_path / out / "detections.jsonl").read_bytes() for out in ("one", "two"))
    assert one == two != b""


def test_a_calibration_may_be_given_for_a_bag_and_the_summary_says_which_was_used(
    drive: Path, model: list[str], tmp_path: Path
) -> None:
    path = write_ours(tmp_path / "a.mcap", (s for s in samples(drive) if s.topic != "/tf_static"))
    file = str(drive / "calibration.toml")
    assert detections(path, model, tmp_path / "out", "--calibration", file)
    assert json.loads((tmp_path / "out" / "summary.json").read_bytes())["calibration"] == file


def test_pictures_of_another_size_than_the_calibration_are_refused_by_name(
    drive: Path, model: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibration = tmp_path / "calibration.toml"
    text = (drive / "calibration.toml").read_text(encoding="utf-8")
    calibration.write_text(text.replace("[640, 480]", "[800, 600]"), encoding="utf-8")
    path = write_ours(tmp_path / "a.mcap", samples(drive))
    assert main(["detect", str(path), *model, "--out", str(tmp_path / "o"), "--calibration", str(calibration)]) == 2
    assert f"{path}: image 0 of /image/compressed: the calibration is for 800x600" in capsys.readouterr().err


def test_pictures_with_boxes_drawn_in_are_not_taken_for_what_the_camera_saw(
    drive: Path, model: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn = (s._replace(topic=s.topic.replace("image", "annotated")) for s in samples(drive))
    path = write_ours(tmp_path / "a.mcap", drawn)
    for verb in (["detect", "--out", str(tmp_path / "out")], ["replay"]):
        assert main([*verb, str(path), *model]) == 2
        assert "a.mcap: expected a topic of camera images" in capsys.readouterr().err
    assert detections(path, model, tmp_path / "asked", "--image-topic", "annotated/compressed")


def test_a_carmen_log_gives_its_scans_and_has_no_frames(tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(LINE * 3, encoding="ascii")
    recording = open_recording(tmp_path / "a.log")
    assert isinstance(recording, CarmenRecording)
    scans = list(recording.messages(laser_latency_ns=4))
    assert all(isinstance(scan, Scan) for scan in scans)
    assert ([scan.stamp_ns for scan in scans], recording.frames) == ([-4, 26_666_663, 53_333_330], 0)
    assert recording.scans == 3


def test_detect_says_that_a_carmen_log_has_no_frames(
    model: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.log").write_text(LINE * 3, encoding="ascii")
    for verb in (["detect", "--out", str(tmp_path / "out")], ["replay"]):
        assert main([*verb, str(tmp_path / "a.log"), *model]) == 2
        assert "a.log: has no images, and what is only in the laser's scans has no name" in capsys.readouterr().err


def test_a_folder_is_a_folder_recording_and_one_that_is_none_says_what_is_missing(drive: Path, tmp_path: Path) -> None:
    assert isinstance(open_recording(drive), FolderRecording)
    with pytest.raises(RefusedError, match=r"scans.npz: missing"):
        open_recording(tmp_path)


@pytest.mark.parametrize("name", ["a.txt", "b"])
def test_what_is_no_recording_is_refused_with_what_would_be(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.txt").write_bytes(b"hello")
    with pytest.raises(RefusedError, match=rf"{name}: .*expected a folder with images/ and scans.npz, an MCAP file"):
        open_recording(tmp_path / name)


@pytest.mark.parametrize("log", ["belgioioso", "csail"])
def test_real_carmen_logs_are_recordings(shared_data: Path, log: str) -> None:
    recording = open_recording(shared_data / "carmen" / f"{log}-corrected.log.gz")
    assert len(list(recording.messages())) == {"belgioioso": 395, "csail": 406}[log]


def test_the_real_drive_is_a_recording(shared_data: Path) -> None:
    assert open_recording(shared_data / "kitti-drive").frames == 77
