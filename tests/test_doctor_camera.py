# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the doctor says of a camera, by the pictures that it really gives."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any, Callable, Iterator

import cv2
import numpy as np
import pytest

from camera_scenes import flat, scene
from doctor_scenes import SEES, examination, told
from edgefusion.sim.mjpeg_server import MjpegServer
from edgefusion.tools.doctor_camera import check_camera
from edgefusion.tools.doctor_finding import Finding
from vision_lab import PaintedCamera

QUICK = {"open_timeout_s": 4.0, "frozen_s": 0.2, "blind_s": 0.2, "lost_s": 2.0, "read_timeout_s": 3.0}


@pytest.fixture
def serve() -> Iterator[Callable[..., str]]:
    """serve(picture of its number) -> the URL of a camera that gives these, 25 a second."""
    end = threading.Event()

    def put(server: MjpegServer, picture: Callable[[int], np.ndarray]) -> None:
        number = 0
        while not end.is_set():
            server.put(cv2.imencode(".jpg", picture(number))[1].tobytes())
            number += 1
            time.sleep(0.04)

    threads = []
    with MjpegServer() as server:

        def made(picture: Callable[[int], np.ndarray]) -> str:
            threads.append(threading.Thread(target=put, args=(server, picture)))
            threads[-1].start()
            return server.url + "stream"

        yield made
        end.set()
        for thread in threads:
            thread.join()


def found(folder: Path, **camera: Any) -> tuple[Finding, tuple[int, int] | None]:
    exam = examination(folder, **SEES, camera={**QUICK, **camera}, service={"processes": ("vision",)})
    (finding,) = check_camera(exam)
    return finding, exam.picture_size


def test_a_camera_that_sees_is_told_with_its_size_and_rate(tmp_path: Path, serve: Any) -> None:
    finding, size = found(tmp_path, source=serve(scene))
    assert told([finding]) == ["ok camera"]
    assert "160x120, " in finding.text and " pictures a second" in finding.text
    assert size == (160, 120)


class Slow(PaintedCamera):
    """25 pictures a second at most, whatever is configured."""

    def __init__(self, *_: Any) -> None:
        super().__init__()

    def __enter__(self) -> Slow:
        return self

    def __exit__(self, *_: Any) -> None:
        pass


def test_a_camera_that_is_slower_than_it_is_to_be_is_warned_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("edgefusion.tools.doctor_camera.Camera", Slow)
    finding, _ = found(tmp_path, source=0, rate_hz=100.0)
    assert told([finding]) == ["warning camera"]
    assert finding.text.endswith(" pictures a second, not 100")
    finding, _ = found(tmp_path, source=0, rate_hz=2.0)
    assert told([finding]) == ["ok camera"]


@pytest.mark.parametrize(
    ("picture", "state", "text", "cure"),
    [
        (lambda number: flat(number % 2), "failed", "CAMERA_BLIND: black pictures", "cap"),
        (lambda number: scene(1), "failed", "CAMERA_FROZEN: the same picture", "unplug"),
        (lambda number: scene(number) // 8, "warning", "too dark: ", "exposure_s"),
        (lambda number: 255 - scene(number) // 8, "warning", "too bright: ", "exposure_s"),
    ],
)
def test_pictures_that_show_little_are_told_with_what_to_do(
    tmp_path: Path, serve: Any, picture: Any, state: str, text: str, cure: str
) -> None:
    finding, _ = found(tmp_path, source=serve(picture))
    assert told([finding]) == [f"{state} camera"]
    assert text in finding.text
    assert cure in finding.cure


def test_a_camera_that_is_not_there_is_lost_and_its_password_is_not_told(tmp_path: Path) -> None:
    finding, size = found(tmp_path, source="http://me:secret@127.0.0.1:9/stream", open_timeout_s=0.2)
    assert told([finding]) == ["failed camera"]
    assert "secret" not in finding.text
    assert size is None


def test_a_camera_is_not_asked_where_vision_runs_elsewhere_or_its_device_is_unusable(tmp_path: Path) -> None:
    elsewhere = examination(tmp_path, service={"processes": ("base",)})
    assert [each.text for each in check_camera(elsewhere)] == ["vision runs on another machine"]
    exam = examination(tmp_path, **SEES, camera={"source": 77})
    exam.unusable.add("/dev/video77")
    assert told(list(check_camera(exam))) == ["skipped camera"]
