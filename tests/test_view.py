# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion view`: where the scan is over the image, and what is in the file that it saves."""

from __future__ import annotations

import math
import os
import signal
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest

from bus_base import STAMPER, Base, Speaker, detection
from bus_lab import Lab, make_keys, until
from edgefusion._core import VISIBLE, Camera, project
from edgefusion.bus import topics
from edgefusion.cli import main
from edgefusion.errors import RefusedError
from edgefusion.messages.frames import BASE_LINK, CAMERA_OPTICAL, LASER
from edgefusion.messages.from_camera_info import from_camera_info
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.from_healths import from_healths
from edgefusion.messages.from_image import from_image
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.from_odometry import from_odometry
from edgefusion.messages.from_path import from_path
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.mission_report import MissionReport
from edgefusion.messages.transform import FrameTransform
from edgefusion.recording import extras
from edgefusion.tools.view_page import page_of
from edgefusion.tools.view_projection import camera_from_laser, pixels, points
from edgefusion.types import Frame, Health, HealthState, Pose2D, Scan, Twist2D

# A camera 10 cm above the laser that looks ahead, too.
T_LASER_CAMERA = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0.1], [0, 0, 0, 1]], float)
T_BASE_LASER = Pose2D(0.2).matrix()
MOUNTING = [FrameTransform(BASE_LINK, LASER, T_BASE_LASER), FrameTransform(LASER, CAMERA_OPTICAL, T_LASER_CAMERA)]
FRAMES = {each.child: each for each in MOUNTING}
PATIENCE_S = 60.0
"""So long a viewer waits for what it shows."""

K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1]], float)
GOAL = MissionReport(stamp_ns=7, state="stopped", reason="look out", goal_id="far", goal_m=(15.0, -9.0))
SCAN = Scan(7, np.full(361, 2.0), -math.pi / 2, math.radians(0.5), 0.0, 8.0)


def test_a_point_straight_ahead_is_below_the_middle_by_the_height_of_the_camera() -> None:
    scan = Scan(0, np.array([2.0, np.inf, np.nan]), 0.0, 0.01)
    T = camera_from_laser(FRAMES)
    assert T is not None
    seen = pixels(scan, Intrinsics((640, 480), K), T)
    np.testing.assert_allclose(seen.uv, [[320, 240 + 500 * 0.1 / 2]])
    np.testing.assert_allclose(seen.ranges_m, [2.0])


@pytest.mark.parametrize("distortion", [(), (-0.25, 0.08, 0.001, -0.002, 0.0)])
def test_the_scan_is_where_the_detector_has_it(distortion: tuple[float, ...]) -> None:
    T = camera_from_laser(FRAMES)
    assert T is not None
    camera = Camera(K, np.array(distortion))
    expected, marks = project(points(SCAN), camera, T)
    inside = (marks == VISIBLE) & ((expected >= 0) & (expected < (640, 480))).all(axis=1)
    found = pixels(SCAN, Intrinsics((640, 480), K, distortion), T)
    np.testing.assert_allclose(found.uv, expected[inside], atol=0.01)
    assert inside.sum() > 50


def test_where_it_is_not_known_how_the_camera_is_mounted_there_is_no_projection() -> None:
    assert camera_from_laser({LASER: MOUNTING[0]}) is None
    loop = {CAMERA_OPTICAL: FrameTransform(LASER, CAMERA_OPTICAL, np.eye(4))}
    loop[LASER] = FrameTransform(CAMERA_OPTICAL, LASER, np.eye(4))
    assert camera_from_laser(loop) is None


def test_a_robot_with_frames_of_its_own_names_has_its_scan_over_the_image_too() -> None:
    mounted = [
        FrameTransform("base_footprint", "base_link", np.eye(4)),
        FrameTransform("base_link", "front_laser", T_BASE_LASER),
        FrameTransform("base_link", "rgb_optical", T_BASE_LASER @ T_LASER_CAMERA),
    ]
    T = camera_from_laser({each.child: each for each in mounted}, "front_laser", "rgb_optical")
    np.testing.assert_allclose(T, np.linalg.inv(T_LASER_CAMERA), atol=1e-12)
    assert camera_from_laser({each.child: each for each in mounted}) is None


def say_everything(base: Speaker) -> None:
    picture = np.zeros((480, 640, 3), np.uint8)
    base.say(topics.TF_STATIC, from_transforms(7, MOUNTING, STAMPER))
    base.say(topics.CAMERA_INFO, from_camera_info(7, Intrinsics((640, 480), K), STAMPER))
    base.say(topics.ODOM, from_odometry(7, Pose2D(1, 2, 0.5), Twist2D(), STAMPER))
    base.say(topics.SCAN, from_scan(SCAN, STAMPER))
    base.say(topics.IMAGE, from_image(Frame(7, picture), STAMPER))
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(7, [detection(7, 2.0)]))
    figures = {"camera": {"infer [ms]": "4.1", "pairs": "12", "runs on": "cpu"}}
    base.say(topics.DIAGNOSTICS, from_healths(7, [Health("camera", HealthState.OK)], STAMPER, figures))
    base.say(topics.PATH, from_path(7, [Pose2D(0, 0), Pose2D(1, 2)], STAMPER))
    base.say(topics.MISSION, from_mission(GOAL))


class Noted:
    """What Rerun was given, in the place of one of its recordings: the newest of each entity."""

    def __init__(self) -> None:
        self.newest: dict[str, Any] = {}

    def log(self, path: str, what: Any, static: bool = False) -> None:
        self.newest[path] = what


def test_the_goal_is_drawn_where_the_mission_has_it_however_the_way_ends() -> None:
    pytest.importorskip("rerun")
    from edgefusion.tools.view_log import ViewLog

    noted = Noted()
    log = ViewLog(noted)
    log.mission(GOAL)
    log.path([Pose2D(0, 0), Pose2D(6, -8)])  # the next ten metres
    assert noted.newest["odom/goal"].positions.as_arrow_array().to_pylist() == [[15.0, -9.0, 0.0]]
    log.path([])  # the robot stands
    assert noted.newest["odom/goal"].labels.as_arrow_array().to_pylist() == ["goal"]
    log.mission(MissionReport(stamp_ns=8, state="idle"))
    assert noted.newest["odom/goal"].positions.as_arrow_array().to_pylist() == []


SHOWN = (
    *(b"camera/image", b"camera/boxes", b"camera/scan", b"odom/path", b"odom/goal", b"laser/scan"),
    *(b"times_ms/camera/infer_ms_", b"figures/camera/pairs"),
)


def test_with_a_viewer_s_keys_the_saved_file_holds_what_the_robot_said(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    file, ended, keys = tmp_path / "a.rrd", threading.Event(), make_keys(tmp_path / "keys")
    with ExitStack() as stack:
        lab = Lab(stack, keys)
        lab.router()
        base = Base(lab)

        def talk() -> None:
            """Until all of it is in the file; then as Ctrl-C."""
            feed = base.session.declare_publisher("robot/path")
            until(lambda: feed.matching_status.matching or ended.is_set(), PATIENCE_S)
            while not ended.wait(0.05):
                say_everything(base)
                if file.exists() and all(entity in file.read_bytes() for entity in SHOWN):
                    os.kill(os.getpid(), signal.SIGINT)
                    return

        talking = threading.Thread(target=talk, daemon=True)
        talking.start()
        where = ["--connect", lab.tls, "--keys", str(keys / "viewer")]
        assert main(["view", "--save", str(file), "--seconds", str(PATIENCE_S), *where]) == 130
        ended.set()
        talking.join()
    content = file.read_bytes()
    assert content.startswith(b"RRF2")
    assert [entity for entity in SHOWN if entity not in content] == []
    assert b"runs_on" not in content
    assert main(["view", "--save", str(file), "--connect", lab.tcp]) == 2


def test_the_address_of_the_page_survives_a_browser() -> None:
    address = "rerun+http://127.0.0.1:9876/proxy"
    assert parse_qs(urlsplit(page_of(address, 9090)).query) == {"url": [address]}


def test_without_rerun_it_is_said_what_to_install() -> None:
    with pytest.raises(RefusedError, match=r"view needs no_such_rerun.*edgefusion\[viewer\]"):
        extras.require("no_such_rerun", "viewer", "view")
