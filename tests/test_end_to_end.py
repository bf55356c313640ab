# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""All of it in real time: devices on ptys, `edgefusion run`, and a laptop that sends the robot and gets the picture."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from benchmarks.end_to_end_figures import drive_figures, latencies, stages_ms
from benchmarks.end_to_end_robot import RobotSetup
from benchmarks.end_to_end_run import EndToEnd, run

from edgefusion.sim.live_devices import LiveSetup
from edgefusion.sim.world_file import load_world
from edgefusion.tools.arguments import LAB_MODEL
from sim_scenes import skip_without_renderer

WORLD = """version = 1
name = "closet"
description = "an oscilloscope before the robot"
seed = 11
floor = "linoleum"
ceiling_m = 3.0
start = [0, 0, 0]
goal = [0.3, 0, 0]
[[walls]]
points = [[-1.5, -2], [4, -2], [4, 2], [-1.5, 2], [-1.5, -2]]
height_m = 3.0
thickness_m = 0.12
finish = "plaster"
[[objects]]
kind = "oscilloscope"
pose = [2.2, 0, 180]
"""


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> EndToEnd:
    """A step towards an oscilloscope, and a moment before it."""
    skip_without_renderer()
    folder = tmp_path_factory.mktemp("end-to-end")
    (folder / "closet.toml").write_text(WORLD, encoding="utf-8")
    world = LiveSetup(load_world(str(folder / "closet.toml")), robot_port=0)
    robot = RobotSetup(LAB_MODEL, threads=1, stand_s=0.2, last_look_s=0.2)
    return run(world, robot, "oscilloscope", folder, rest_s=0)


def test_a_robot_that_a_laptop_sends_arrives_without_touching_anything(drive: EndToEnd) -> None:
    figures = drive_figures(drive)
    assert figures.good, figures.said
    assert figures.error_m < 0.1


def test_the_laptop_knows_what_stands_before_the_robot(drive: EndToEnd) -> None:
    assert any("oscilloscope" in labels for _, _, labels in drive.laptop["frames"])
    assert latencies(drive)["capture to the laptop"].p50 > 0
    assert stages_ms(drive)["inference"] > 0


def test_the_picture_that_the_laptop_gets_is_the_one_that_the_robot_keeps(drive: EndToEnd) -> None:
    (inspection,) = drive.laptop["inspections"]
    (record,) = drive.folder.glob("inspections/*.json")
    kept = json.loads(record.read_text(encoding="utf-8"))
    delivered = (drive.folder / "delivered-0.jpg").read_bytes()
    assert (drive.folder / "inspections" / kept["picture"]["file"]).read_bytes() == delivered
    assert kept["label"] == inspection["label"] == "oscilloscope"
    assert kept["picture"]["stamp_ns"] == inspection["picture_ns"]
    assert cv2.imdecode(np.frombuffer(delivered, np.uint8), cv2.IMREAD_COLOR).shape == (480, 640, 3)


def test_the_base_says_how_late_it_was_and_whether_it_had_real_time(drive: EndToEnd) -> None:
    said = drive.laptop["figures"][-1][1]["base"]
    assert int(said["cycles"]) > 20
    assert 0 <= float(said["lateness p50 [ms]"]) <= float(said["lateness p99 [ms]"])
    assert "threads" in said["real time"]


def test_each_process_is_seen_and_none_fails(drive: EndToEnd) -> None:
    assert set(drive.at_rest) == {"supervisor", "bus", "base", "vision", "vision's camera"}
    assert "Traceback" not in (drive.folder / "robot.log").read_text(encoding="utf-8")
