# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion demo` as a user runs it: a real drive through a small world, and the report that it leaves.

It stops for the scope there, which its network calls a loudspeaker. The paper's experiment is in test_experiment.py.
"""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path

import cv2
import numpy as np
import pytest

from edgefusion.cli import main
from edgefusion.errors import RefusedError
from edgefusion.perception.make_model import make_model_folder
from edgefusion.tools.report_plots import check_matplotlib
from make_colour_network import save_colour_network
from sim_scenes import skip_without_renderer

skip_without_renderer()

NAME = "a <small> world & more"
WORLD = f"""
version = 1
name = "{NAME}"
description = "a wall, two objects before it and a short way towards them"
seed = 3
floor = "linoleum"
start = [0, 0, 0]
goal = [1.0, 0.3, 20]
walls = [{{ points = [[5, -3], [5, 3]], height_m = 2.5, thickness_m = 0.12, finish = "plaster" }}]
objects = [
  {{ name = "the scope", kind = "oscilloscope", pose = [2.6, 0.7, 180] }},
  {{ name = "the cone", kind = "traffic cone", pose = [3.9, -0.9, 0] }},
]
"""
SECTIONS = (
    "path", "inspections", "poses", "mission", "gate", "first-sightings", "sightings", "objects", "errors", "stages",
)  # fmt: skip
INSPECT = ("--inspect", "loudspeaker")
A_STEP = ("--goal", "0.2", "0", "0")
"""For those that are not about the way."""


@pytest.fixture(scope="module")
def arguments(tmp_path_factory) -> list[str]:
    """The small world, and a model that calls everything an oscilloscope or a loudspeaker by its colour."""
    folder = tmp_path_factory.mktemp("demo")
    (folder / "small.toml").write_text(WORLD, encoding="utf-8")
    net = save_colour_network(folder / "net", {"oscilloscope": (120, 120, 120), "loudspeaker": (0, 0, 255)})
    make_model_folder(net, ["oscilloscope", "loudspeaker"], folder / "model", name="c", origin="here", licence="none")
    return ["--world", str(folder / "small.toml"), "--model", str(folder / "model")]


def command(*more: object) -> list[str]:
    return [sys.executable, "-m", "edgefusion.cli", "demo", *map(str, more)]


def edgefusion_demo(*more: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*more), capture_output=True, text=True, cwd=cwd, check=False)


@pytest.fixture(scope="module")
def first(arguments, tmp_path_factory) -> Path:
    """The report of a first run, made where it goes by itself."""
    cwd = tmp_path_factory.mktemp("cwd")
    done = edgefusion_demo(*arguments, *INSPECT, cwd=cwd)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("arrived:")
    assert f"report:          {Path('out', 'demo', 'index.html')}" in done.stdout
    return cwd / "out" / "demo"


@pytest.fixture(scope="module")
def report(first: Path) -> dict:
    return json.loads((first / "report.json").read_text(encoding="utf-8"))


def test_the_numbers_agree_with_each_other(report: dict, first: Path) -> None:
    lines = [json.loads(line) for line in (first / "detections.jsonl").read_text(encoding="utf-8").splitlines()]
    assert len(lines) == report["detections"] > 0
    assert {line["frame"] for line in lines} <= set(range(report["frames"]))
    assert report["pairing"]["frame paired"] == report["frames"] >= 10
    counted = [row for row in report["by_object"] if row["counts"]]
    assert report["objects"]["in_view"] == len(counted)
    assert report["objects"]["found"] == sum(row["found"] for row in counted)
    assert report["objects"]["named"] == sum(row["found"] and row["named"] for row in counted)
    assert set(report["stages_ms"]) == {"cluster", "crop", "infer", "vote", "whole frame"}
    assert all(0 <= ms["median"] <= ms["p95"] for ms in report["stages_ms"].values())
    assert report["world"] == NAME and report["version"] == 2


def test_both_objects_are_found_and_measured(report: dict) -> None:
    rows = {row["name"]: row for row in report["by_object"]}
    assert set(rows) == {"the scope", "the cone"}
    assert report["objects"]["found"] == report["objects"]["in_view"] == 2
    assert rows["the scope"]["label"] == "oscilloscope"
    assert all(row["distance_error_mm_median"] < 30 and 0 < row["iou_median"] <= 1 for row in rows.values())
    assert report["distance_error_mm"]["median"] < 30


def test_sightings_are_confirmed_and_lie_where_the_objects_are(report: dict) -> None:
    places = {"the scope": (2.6, 0.7), "the cone": (3.9, -0.9)}
    owned = [row for row in report["sightings"] if row["object"] in places]
    assert {row["object"] for row in owned} == set(places)
    for row in owned:
        assert row["frames"] >= 3
        assert np.hypot(*np.subtract(row["place_m"], places[row["object"]])) < 0.5
        assert row["distance_m"] == pytest.approx(row["true_distance_m"], abs=0.1)


def test_the_drive_ends_at_its_goal_and_takes_its_time(report: dict) -> None:
    drive = report["drive"]
    assert drive["outcome"] == "arrived" and drive["arrived"] and drive["reason"] == ""
    assert drive["odometry_error_m"] < 0.05 and drive["odometry_error_deg"] < 3
    assert drive["true_error_m"] < 0.15 and drive["true_error_deg"] < 6
    assert 1.0 < drive["way_m"] < 1.3
    assert 10 + drive["way_m"] / 0.5 < drive["duration_s"] < 40
    assert 1 < drive["clearance_m"] < 2.5


def test_it_stops_once_before_what_it_is_to_inspect_and_keeps_the_picture(report: dict, first: Path) -> None:
    (row,) = report["mission"]["inspections"]
    assert (row["label"], row["object"], row["reason"]) == ("loudspeaker", "the scope", "")
    assert np.hypot(*np.subtract(row["place_m"], (2.6, 0.7))) < 0.5
    assert row["ended_s"] - row["stood_s"] == pytest.approx(10, abs=0.1)
    assert cv2.imread(str(first / row["picture"])).shape == (480, 640, 3)
    kept = json.loads((first / row["json"]).read_text(encoding="utf-8"))
    assert kept["label"] == "loudspeaker" and kept["picture"]["file"] == Path(row["picture"]).name
    assert kept["detection"]["stamp_ns"] == kept["picture"]["stamp_ns"] >= 1e9 * row["stood_s"]


def test_what_the_mission_did_is_told_in_order(report: dict) -> None:
    events = report["mission"]["events"]
    assert [event["stamp_s"] for event in events] == sorted(event["stamp_s"] for event in events)
    whats = [event["what"] for event in events]
    assert whats[0] == "driving" and whats[-1] == "arrived"
    assert whats.count("asks for a picture: loudspeaker") == whats.count("inspected, has a picture") == 1


def test_the_gate_begins_with_a_stop_and_lets_the_rest_pass(report: dict) -> None:
    gate = report["gate"]
    assert gate["spells"][0]["action"] == "stop" and gate["spells"][0]["from_s"] == 0
    assert gate["decisions"]["stop_latched"] == 0
    assert sum(gate["decisions"].values()) == pytest.approx(report["drive"]["duration_s"] / 0.05, abs=2)
    stopped_s = sum(each["until_s"] - each["from_s"] for each in gate["spells"] if each["action"] == "stop")
    assert gate["decisions"]["stop"] * 0.05 == pytest.approx(stopped_s, abs=0.06)


def test_the_page_has_every_section_and_needs_nothing_from_elsewhere(first: Path) -> None:
    page = (first / "index.html").read_text(encoding="utf-8")
    for name in SECTIONS:
        assert f'<section id="{name}">' in page
    links = re.findall(r'(?:src|href|srcset)="([^"]+)"', page)
    assert len(links) > len(SECTIONS)
    assert all((first / link).is_file() for link in links), links
    assert "://" not in page and "<script" not in page and "@import" not in page


def test_names_cannot_break_the_page(first: Path) -> None:
    page = (first / "index.html").read_text(encoding="utf-8")
    assert "a &lt;small&gt; world &amp; more" in page
    assert "<small>" not in page


def test_every_picture_of_a_sighting_is_there(first: Path, report: dict) -> None:
    pictured = [row for row in report["sightings"] if row["image"]]
    assert pictured
    for row in pictured:
        assert cv2.imread(str(first / row["image"])).shape == (480, 640, 3)
        assert cv2.imread(str(first / row["scan"])).shape == (640, 640, 3)


def test_a_world_with_nothing_in_it_gets_its_page_too(arguments, tmp_path: Path, capsys) -> None:
    empty = re.sub(r"(walls|objects) = \[.*?\n?\]\n(?=[a-z]|$)", "", WORLD, flags=re.DOTALL)
    (tmp_path / "empty.toml").write_text(empty, encoding="utf-8")
    empty_world = ["--world", str(tmp_path / "empty.toml"), *A_STEP]
    assert main(["demo", *arguments, *empty_world, "--out", str(tmp_path / "out")]) == 0
    assert "found:           0 of 0 objects" in capsys.readouterr().out
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["sightings"] == report["by_object"] == []
    assert report["distance_error_mm"]["median"] is None and report["drive"]["clearance_m"] is None
    assert "Nothing was." in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


def test_a_second_run_goes_beside_the_first_and_the_same_seed_gives_the_same(
    first: Path, arguments, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(first.parents[1])
    assert main(["demo", *arguments, *INSPECT, "--json"]) == 0
    second = first.with_name("demo-2")
    report = json.loads(capsys.readouterr().out)
    assert report == json.loads((second / "report.json").read_text(encoding="utf-8"))
    assert (second / "detections.jsonl").read_bytes() == (first / "detections.jsonl").read_bytes()
    for plot in ("plan.svg", "pose-dark.svg", "inspection-1.svg"):
        assert (second / "plots" / plot).read_bytes() == (first / "plots" / plot).read_bytes()


def test_a_report_is_replaced_only_when_asked_to(arguments, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    (out / "annotated").mkdir(parents=True)
    (out / "inspections").mkdir()
    for name in ("report.json", "detections.jsonl", "annotated/old.jpg", "inspections/old.json", "mine.txt"):
        (out / name).touch()
    drive = ["demo", *arguments, *A_STEP, "--out", str(out)]
    assert main(drive) == 2
    assert capsys.readouterr().err.endswith("exists already; --overwrite replaces it, --out takes another\n")
    assert main([*drive, "--overwrite"]) == 0
    assert not (out / "annotated" / "old.jpg").exists() and not (out / "inspections").exists()
    assert (out / "mine.txt").exists()
    assert (out / "report.json").stat().st_size > 100


def test_one_who_is_interested_in_nothing_stops_for_nothing(arguments, tmp_path: Path, capsys) -> None:
    assert main(["demo", *arguments, "--no-inspect", "--json", "--out", str(tmp_path / "out")]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["mission"]["inspections"] == [] and report["drive"]["duration_s"] < 10
    assert not (tmp_path / "out" / "inspections").exists()


@pytest.mark.parametrize(
    ("more", "named"),
    [
        (["--world", "moon"], "world: expected a .toml file or one of"),
        (["--world", "missing.toml"], "missing.toml: cannot be read"),
        (["--model", "missing"], "missing: "),
        (["--out", "file"], "file: cannot write there"),
        (["--port", "8000"], "--port 8000: expected --view beside it"),
        (["--inspect", "loudspeaker", "--inspect", "oscilliscope"], "'oscilliscope': no label or group of the model"),
        (["--inspect", "oscilliscope"], "did you mean oscilloscope?"),
        (["--goal", "nan", "0", "0"], "--goal nan 0 0: expected metres and degrees below 1000"),
    ],
)
def test_what_cannot_be_is_refused_with_one_line(arguments, tmp_path, monkeypatch, capsys, more, named) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    assert main(["demo", *arguments, *more]) == 2
    error = capsys.readouterr().err
    assert named in error and error.count("\n") == 1
    assert not Path("out").exists()


@pytest.mark.parametrize(("option", "value"), [("--seed", "-1"), ("--seed", "x"), ("--port", "65536")])
def test_a_number_that_cannot_be_is_refused_in_words(capsys, option: str, value: str) -> None:
    with pytest.raises(SystemExit):
        main(["demo", f"{option}={value}"])
    assert f"argument {option}: expected a whole number from 0" in capsys.readouterr().err


def test_a_goal_that_cannot_be_reached_is_said_to_be_so_with_exit_code_1(arguments, tmp_path: Path, capsys) -> None:
    inside_the_cone = ["--goal", "3.9", "-0.9", "0"]
    assert main(["demo", *arguments, *inside_the_cone, "--out", str(tmp_path / "out")]) == 1
    assert "blocked:         goal inside an obstacle\n" in capsys.readouterr().out
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["drive"]["goal"] == pytest.approx([3.9, -0.9, 0]) and not report["drive"]["arrived"]
    assert report["mission"]["events"][-1]["what"] == "blocked: goal inside an obstacle"
    assert report["drive"]["clearance_m"] > 0


def test_without_matplotlib_it_says_how_to_get_it(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(RefusedError, match=r"pip install 'edgefusion\[sim\]'"):
        check_matplotlib()


def test_the_live_view_shows_the_drive_and_ends_on_ctrl_c(arguments, tmp_path: Path) -> None:
    for_half_a_minute = ("--goal", "-8", "0", "0")
    process = subprocess.Popen(
        command(*arguments, *for_half_a_minute, "--view", "--out", tmp_path / "out"), stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    with process, process.stderr:
        url = re.search(r"http://127\.0\.0\.1:(\d+)/", process.stderr.readline())
        assert url is not None
        with urllib.request.urlopen(url[0], timeout=300) as page:
            assert b'<img src="stream"' in page.read()
        with urllib.request.urlopen(f"{url[0]}stream", timeout=300) as stream:
            pictures = [next_picture(stream) for _ in range(2)]
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=300) == 130
        assert process.stderr.read().splitlines()[-1] == "edgefusion: interrupted"
    assert all(picture.shape == (480, 640 + 480, 3) for picture in pictures)
    assert (pictures[0] != pictures[1]).any()
    with socket.socket() as again:
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", int(url[1])))


def next_picture(stream) -> np.ndarray:
    """The next JPEG of a multipart stream."""
    while not (match := re.match(rb"Content-Length: (\d+)", stream.readline())):
        pass
    assert stream.readline() == b"\r\n"
    return cv2.imdecode(np.frombuffer(stream.read(int(match[1])), np.uint8), cv2.IMREAD_COLOR)
