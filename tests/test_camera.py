# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The whole camera: real files, a real stream that fails on demand, and reads that hang."""

from __future__ import annotations

import threading
from pathlib import Path

import cv2
import pytest

from camera_scenes import HEIGHT, WIDTH, MjpegServer, ScriptedSource, scene, wait_until
from edgefusion.clock import SimClock, system_clock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera import Camera
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.types import HealthState


@pytest.fixture
def server():
    server = MjpegServer()
    yield server
    server.stop()


def film(path: Path, count: int, rate_hz: float = 30.0) -> str:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), rate_hz, (WIDTH, HEIGHT))
    for number in range(count):
        writer.write(scene(number))
    writer.release()
    return str(path)


def is_well(camera: Camera) -> bool:
    return camera.health().state is HealthState.OK


def shows(camera: Camera, code: str) -> bool:
    return camera.health().reason.startswith(code)


def gives(camera: Camera) -> bool:
    """A picture; it may be lost again between what it says and what it gives."""
    try:
        return camera.latest(60.0).image.shape == (HEIGHT, WIDTH, 3)
    except NoFrameError:
        return False


def refuses(camera: Camera, code: str) -> bool:
    """Whether it says so and gives that as the reason for no picture; it may be found again in between."""
    if not shows(camera, code):
        return False
    try:
        camera.latest(60.0)
    except NoFrameError as error:
        return code in str(error)
    return False


def test_every_picture_of_a_file_comes_in_order_at_its_pace_stamped_by_this_clock(tmp_path: Path) -> None:
    begin_ns = system_clock()
    config = CameraConfig(source=film(tmp_path / "a.avi", 20), rate_hz=100.0, keep_s=10.0, longest_pause_s=60.0)
    with Camera(config) as camera:
        wait_until(lambda: len(camera.after(0)) >= 20)
        frames = camera.after(0)[:20]
    stamps = [frame.stamp_ns for frame in frames]
    assert min(later - earlier for earlier, later in zip(stamps, stamps[1:])) >= 10_000_000
    assert begin_ns < stamps[0]
    assert stamps[-1] < system_clock()
    for number, frame in enumerate(frames):
        assert cv2.absdiff(frame.image, scene(number)).mean() < 12  # JPEG
        assert not frame.image.flags.writeable


def test_a_file_that_ends_is_lost_with_that_reason_and_begins_again(tmp_path: Path) -> None:
    with Camera(CameraConfig(source=film(tmp_path / "a.avi", 3), first_pause_s=0.5)) as camera:
        for _ in range(2):
            wait_until(lambda: is_well(camera))
            wait_until(lambda: camera.health().reason.endswith("a.avi: no more pictures"))


def test_a_file_that_appears_later_is_found(tmp_path: Path) -> None:
    with Camera(CameraConfig(source=str(tmp_path / "a.avi"))) as camera:
        wait_until(lambda: shows(camera, f"CAMERA_LOST: {tmp_path}/a.avi: not there"))
        film(tmp_path / "b.avi", 100)
        (tmp_path / "b.avi").rename(tmp_path / "a.avi")
        wait_until(lambda: is_well(camera))


def test_what_is_no_video_is_lost_with_a_reason(tmp_path: Path) -> None:
    (tmp_path / "a.avi").write_text("no video", encoding="utf-8")
    with Camera(CameraConfig(source=str(tmp_path / "a.avi"))) as camera:
        wait_until(lambda: shows(camera, f"CAMERA_LOST: {tmp_path}/a.avi: cannot be opened"))


def test_pictures_of_another_size_than_configured_are_refused(tmp_path: Path) -> None:
    config = CameraConfig(source=film(tmp_path / "a.avi", 30), width=640, height=480)
    with Camera(config) as camera:
        wait_until(lambda: "expected pictures of 640x480, got 160x120" in camera.health().reason)
        assert camera.after(0) == []


def test_a_stream_that_closes_is_lost_and_found_again(server: MjpegServer) -> None:
    with Camera(CameraConfig(source=server.url)) as camera:
        wait_until(lambda: is_well(camera) and gives(camera))
        server.behaviour = "close"
        wait_until(lambda: refuses(camera, "CAMERA_LOST"))
        server.behaviour = "stream"
        wait_until(lambda: is_well(camera))


def test_a_stream_that_freezes_is_frozen_until_it_moves_again(server: MjpegServer) -> None:
    with Camera(CameraConfig(source=server.url)) as camera:
        wait_until(lambda: is_well(camera))
        server.behaviour = "freeze"
        wait_until(lambda: refuses(camera, "CAMERA_FROZEN") and camera.after(0) == [])
        server.behaviour = "stream"
        wait_until(lambda: is_well(camera))


def test_a_stream_that_hangs_is_abandoned_and_opened_again(server: MjpegServer) -> None:
    with Camera(CameraConfig(source=server.url, read_timeout_s=0.5)) as camera:
        wait_until(lambda: is_well(camera))
        before, server.behaviour = server.connections, "hang"
        wait_until(lambda: shows(camera, "CAMERA_LOST"))
        wait_until(lambda: server.connections > before)
        server.behaviour = "stream"
        wait_until(lambda: is_well(camera))


def test_a_read_that_never_returns_keeps_nobody_else_waiting() -> None:
    reading, let_go, clock = threading.Event(), threading.Event(), SimClock()

    class Hanging(ScriptedSource):
        def read(self, timeout_s: float) -> None:
            reading.set()
            let_go.wait()

    camera = Camera(CameraConfig(), clock, lambda: Hanging([]))
    assert reading.wait(30)
    assert camera.health().state is HealthState.STARTING
    with pytest.raises(NoFrameError, match="CAMERA_STARTING"):
        camera.latest(1.0)
    assert camera.after(0) == []
    let_go.set()
    camera.close()


def test_closing_lets_go_of_the_device() -> None:
    source, opened = ScriptedSource([]), threading.Event()

    def opener() -> ScriptedSource:
        opened.set()
        return source

    with Camera(CameraConfig(), SimClock(), opener):
        assert opened.wait(30)
    assert source.closed == 1
