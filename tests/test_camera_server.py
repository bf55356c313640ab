# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated camera's stream: who reads it, what it carries, and our own driver at its other end."""

from __future__ import annotations

import os
import signal
import socket
import time
import urllib.error
import urllib.request
from typing import BinaryIO, Iterator, Tuple

import cv2
import numpy as np
import pytest
from benchmarks.faults_camera_rig import CameraRig, capturing

from camera_scenes import wait_until
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.errors import RefusedError
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.live_camera import LiveCamera, Picture
from edgefusion.sim.mjpeg_server import STAMP_HEADER, MjpegServer
from edgefusion.sim.world_file import load_world
from edgefusion.types import Pose2D
from sim_scenes import skip_without_renderer

LIMIT_S = 30.0


@pytest.fixture
def server() -> Iterator[MjpegServer]:
    with MjpegServer() as server:
        yield server


def opened(server: MjpegServer) -> BinaryIO:
    return urllib.request.urlopen(server.url + "stream", timeout=LIMIT_S)


def part(stream: BinaryIO) -> Tuple[int | None, bytes]:
    """The next picture, and its stamp."""
    line, headers = stream.readline(), {}
    assert line.startswith(b"--")
    while True:
        line = stream.readline().strip()
        if not line:
            break
        name, _, value = line.decode().partition(": ")
        headers[name] = value
    assert headers["Content-Type"] == "image/jpeg"
    picture = stream.read(int(headers["Content-Length"]))
    assert stream.readline() == b"\r\n"
    return int(headers[STAMP_HEADER]) if STAMP_HEADER in headers else None, picture


def test_a_picture_comes_byte_for_byte_with_its_stamp(server: MjpegServer) -> None:
    server.put(b"\xff\xd8 one \r\n--frame\r\n", 12_345_678_901_234_567)
    with opened(server) as stream:
        assert part(stream) == (12_345_678_901_234_567, b"\xff\xd8 one \r\n--frame\r\n")
        server.put(b"two")
        assert part(stream) == (None, b"two")


def test_each_of_several_readers_gets_every_picture_that_it_waits_for(server: MjpegServer) -> None:
    streams = [opened(server) for _ in range(3)]
    for number in range(5):
        server.put(b"picture %d" % number, number)
        assert [part(stream) for stream in streams] == [(number, b"picture %d" % number)] * 3
    for stream in streams:
        stream.close()


def test_one_who_does_not_read_holds_up_nobody_and_misses_what_is_old(server: MjpegServer) -> None:
    host, _, port = server.url[len("http://") : -1].partition(":")
    with socket.create_connection((host, int(port))) as sleeper, opened(server) as stream:
        sleeper.sendall(b"GET /stream HTTP/1.0\r\n\r\n")
        big = bytes(1_000_000)  # more than a socket holds, a few times
        for number in range(20):
            server.put(big, number)
            assert part(stream)[0] == number
        sleeper.settimeout(LIMIT_S)
        with sleeper.makefile("rb") as late:
            while late.readline().strip():
                pass
            stamps = [part(late)[0]]
            while stamps[-1] != 19:
                stamps.append(part(late)[0])
    assert len(stamps) < 15


def test_there_is_a_page_to_look_at_and_nothing_else(server: MjpegServer) -> None:
    with urllib.request.urlopen(server.url, timeout=LIMIT_S) as page:
        assert page.headers["Content-Type"].startswith("text/html") and b'src="stream"' in page.read()
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(server.url + "nothing", timeout=LIMIT_S)


def test_it_is_served_to_this_machine_alone_and_a_taken_port_is_refused(server: MjpegServer) -> None:
    assert server.url.startswith("http://127.0.0.1:")
    port = int(server.url[:-1].rsplit(":", 1)[1])
    with pytest.raises(RefusedError, match=f"port {port}: cannot be served"):
        MjpegServer(port)


def test_closing_ends_the_streams_and_gives_the_port_back() -> None:
    first = MjpegServer()
    port = int(first.url[:-1].rsplit(":", 1)[1])
    first.put(b"one", 1)
    with opened(first) as stream:
        assert part(stream)[1] == b"one"
        first.close()
        assert stream.readline() == b"--frame\r\n" and stream.read() == b""
    MjpegServer(port).close()


@pytest.mark.parametrize(("fault", "grey"), [("camera=wrong", 0), ("camera=wrong:0.4", 102), ("camera=wrong:1", 255)])
def test_a_covered_lens_is_as_bright_as_it_is_told_and_only_between_black_and_white_it_has_noise(fault, grey) -> None:
    covered = FaultyPictures(parse_fault(fault), np.random.default_rng(0), 0)
    jpeg = cv2.imencode(".jpg", np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8))[1].tobytes()
    sent = [covered.sent(Picture(number, jpeg), number)[0].jpeg for number in range(2)]
    for picture in sent:
        image = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)
        assert image.shape == (48, 64, 3) and np.abs(image.astype(int) - grey).max() <= 5
    assert (sent[0] == sent[1]) == (grey in (0, 255))


def test_a_covered_lens_leaves_what_is_no_picture_as_it_is() -> None:
    covered = FaultyPictures(parse_fault("camera=wrong"), np.random.default_rng(0), 0)
    assert covered.sent(Picture(1, b"no picture"), 1) == [Picture(1, b"no picture")]


def picture_or_reason(rig: CameraRig) -> Tuple[int, ...] | str:
    """The size of the newest picture, or why there is none; what the driver says may change at any time."""
    try:
        return rig.camera.latest(LIMIT_S).image.shape
    except NoFrameError as error:
        return str(error)


def test_our_driver_sees_it_and_says_what_is_wrong_with_it() -> None:
    with CameraRig(0) as rig:
        wait_until(lambda: picture_or_reason(rig) == (480, 640, 3), LIMIT_S)
        for fault, code in (
            ("camera=stuck", "CAMERA_FROZEN"),
            ("camera=wrong:0.4", "CAMERA_BLIND: covered"),
            ("camera=off", "CAMERA_LOST"),
        ):
            rig.inject(fault)
            wait_until(lambda code=code: rig.says(code) and code in str(picture_or_reason(rig)), LIMIT_S)
            rig.mend()
            wait_until(lambda: rig.is_well, LIMIT_S)


def test_our_driver_outlives_broken_pictures_and_late_and_missing_ones() -> None:
    with CameraRig(1) as rig:
        for fault in ("camera=garbage:0.2", "camera=garbage:1", "camera=delayed:0.2", "camera=intermittent"):
            rig.inject(fault)
            time.sleep(0.3)
        rig.mend()
        wait_until(lambda: rig.is_well and rig.ask(), LIMIT_S)


def test_our_driver_finds_it_again_where_it_was_unplugged() -> None:
    with CameraRig(2) as rig:
        rig.unplug()
        wait_until(lambda: rig.says("CAMERA_LOST"), LIMIT_S)
        rig.plug()
        wait_until(lambda: rig.is_well, LIMIT_S)


def test_c4_a_reader_that_stands_still_is_replaced_and_nobody_waits_for_it() -> None:
    with CameraRig(3) as rig:
        (reader,) = capturing()
        os.kill(reader, signal.SIGSTOP)
        wait_until(lambda: rig.says("CAMERA_LOST"), LIMIT_S)
        wait_until(lambda: rig.is_well, LIMIT_S)
        assert reader not in capturing()
    assert capturing() == []


def taken(camera: LiveCamera) -> Picture:
    """The next picture, however long it takes."""
    found: list[Picture] = []

    def came() -> bool:
        found.extend(filter(None, [camera.take()]))
        return bool(found)

    wait_until(came, LIMIT_S)
    return found[0]


def test_a_picture_is_rendered_from_where_it_was_asked_for_one_after_the_other() -> None:
    skip_without_renderer()
    camera = LiveCamera(load_world("laboratory"), 0)
    try:
        assert not camera.ask(1, Pose2D(), 0.0)  # its child only begins
        wait_until(lambda: camera.take() is None and camera.ready, LIMIT_S)
        pictures = []
        for stamp_ns, theta in ((11, 0.0), (12, 1.5)):
            assert camera.ask(stamp_ns, Pose2D(1.0, 1.0, theta), 0.0) and not camera.ask(99, Pose2D(), 0.0)
            pictures.append(taken(camera))
    finally:
        camera.close()
    assert [picture.stamp_ns for picture in pictures] == [11, 12]
    images = [cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR) for picture in pictures]
    assert images[0].std() > 10 and np.abs(images[0].astype(int) - images[1]).mean() > 10


def test_a_renderer_that_died_is_told_and_asked_no_more() -> None:
    skip_without_renderer()
    camera = LiveCamera(load_world("laboratory"), 0)
    try:
        wait_until(lambda: camera.take() is None and camera.ready, LIMIT_S)
        os.kill(camera.pid, signal.SIGKILL)
        wait_until(lambda: camera.take() is None and not camera.ready, LIMIT_S)
        assert camera.fault == "the camera's process has ended" and not camera.ask(1, Pose2D(), 0.0)
    finally:
        camera.close()
