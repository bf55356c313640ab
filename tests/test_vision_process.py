# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The process of vision: what it refuses to start with, and that it names what a camera on the network sees."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

import edgefusion
from bus_lab import Lab, until
from camera_scenes import MjpegServer
from edgefusion.bus.healths import Healths
from edgefusion.bus.latest import Latest
from edgefusion.bus.topics import DETECTIONS_DETAIL
from edgefusion.cli import main
from edgefusion.clock import system_clock
from edgefusion.config import VisionConfig
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.perception.runtime_options import runtime_options
from edgefusion.service.heartbeat import ENVIRONMENT
from vision_lab import FakeBase
from vision_scenes import MS

MODEL = Path(edgefusion.__file__).parent / "data" / "lab-model"
K = [[150.0, 0, 79.5], [0, 150.0, 59.5], [0, 0, 1]]
T = [[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]


def write_config(folder: Path, model: Path, camera: str = "nowhere.avi", router: str = "tcp/127.0.0.1:7447") -> Path:
    (folder / "calibration.toml").write_text(
        f"version = 1\nimage_size = [160, 120]\nK = {K}\nT_camera_laser = {T}\nlaser_height_m = 0.25\n",
        encoding="utf-8",
    )
    path = folder / "robot.toml"
    path.write_text(
        f'[camera]\nsource = "{camera}"\n[bus]\nlisten = ["{router}"]\n'
        f'[vision]\nmodel = "{model}"\ncalibration = "calibration.toml"\nthreads = 1\n',
        encoding="utf-8",
    )
    return path


def damaged(folder: Path, name: str, change: str) -> Path:
    """A model folder with a bit flipped in the middle of a file, or its end missing, or another's labels."""
    model = folder / "model"
    model.mkdir()
    for file in MODEL.iterdir():
        (model / file.name).write_bytes(file.read_bytes())
    content = bytearray((model / name).read_bytes())
    if change == "flip":
        content[len(content) // 2] ^= 4
    elif change == "cut":
        del content[len(content) // 2 :]
    else:
        content += b"one more\n"
    (model / name).write_bytes(content)
    return model


@pytest.mark.parametrize(
    ("name", "change"),
    [("model.onnx", "flip"), ("model.onnx", "cut"), ("labels.txt", "add"), ("golden.png", "flip")],
)
def test_a_model_that_is_damaged_is_refused_with_one_line_before_the_camera_is_touched(
    tmp_path: Path, capsys, monkeypatch, name: str, change: str
) -> None:
    monkeypatch.setattr("edgefusion.service.vision_process.Camera", pytest.fail)
    monkeypatch.setattr("edgefusion.service.logs.set_up_logs", lambda *_: None)
    config = write_config(tmp_path, damaged(tmp_path, name, change))
    assert main(["vision", "--config", str(config)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert name in line


def test_without_a_model_it_is_refused(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("edgefusion.service.logs.set_up_logs", lambda *_: None)
    (tmp_path / "robot.toml").write_text("", encoding="utf-8")
    assert main(["vision", "--config", str(tmp_path / "robot.toml")]) == 2
    assert "vision.model: expected a model folder" in capsys.readouterr().err


def test_a_provider_that_is_required_is_not_stood_in_for() -> None:
    settings = VisionConfig(provider="cuda", require_provider=True)
    assert runtime_options(settings).require == "cuda"
    assert runtime_options(VisionConfig(provider="cuda")).require is None


def test_the_process_sees_says_when_its_camera_hangs_and_ends_as_asked(tmp_path: Path) -> None:
    with ExitStack() as stack:
        lab, server = Lab(stack), MjpegServer()
        stack.callback(server.stop)
        lab.router()
        config = write_config(tmp_path, MODEL, server.url, lab.tcp)
        with config.open("a", encoding="utf-8") as file:
            file.write("[mission]\ninterest = ['oscilloscope', 'unicorn']\n")
        mine, line = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        environment = {**os.environ, ENVIRONMENT: str(line.fileno())}
        command = [sys.executable, "-m", "edgefusion.cli", "vision", "--config", str(config)]
        process = subprocess.Popen(
            command, env=environment, pass_fds=[line.fileno()], stderr=subprocess.PIPE, text=True
        )
        stack.callback(process.kill)
        line.close()
        base = FakeBase(lab)
        base.scan = type(base.scan)(1, np.full(361, 2.0, np.float32), -np.pi / 2, np.radians(0.5))
        laptop = lab.client()
        detail = Latest(laptop, "robot", DETECTIONS_DETAIL, to_detections_detail, system_clock)
        states = Healths(laptop, "robot", system_clock)

        def seen() -> bool:
            base.speak()
            return detail.value is not None

        until(seen, 30.0)
        mine.setblocking(False)
        assert b"says" in mine.recv(10_000)
        server.behaviour = "hang"

        def hangs() -> bool:
            base.speak()
            return any(report.health.reason.startswith("CAMERA_LOST") for report in states.reports)

        until(hangs, 20.0)
        figures = next(report.figures for report in states.reports if report.health.component == "detector")
        assert figures["scheduling"].startswith(("shared, nice ", "real time, "))
        # It may still have been at work on a picture of before: what counts is when that was taken.
        lost_ns = system_clock()
        until(lambda: seen() and system_clock() > lost_ns + 500 * MS)
        assert detail.value.stamp_ns < lost_ns
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=20)
        mine.close()
    assert process.returncode == 0
    assert "first look" in said
    assert "mission.interest: never seen: " in said and "unicorn" in said
    assert "Traceback" not in said
