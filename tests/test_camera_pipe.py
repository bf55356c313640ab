# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A child's output arrives whole however it comes, its last words are told, and it never outlives its pipe."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import msgspec
import pytest

from camera_scenes import scene
from edgefusion.clock import SimClock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_pipe import ChildPipe, PipeEndedError
from edgefusion.drivers.camera_source import HEADER, MAGIC, BarePictures, StampedPictures

LIMIT_S = 30.0


def python(code: str) -> list[str]:
    return [sys.executable, "-c", f"import os, signal, sys, time\n{code}"]


def read(source, limit_s: float = LIMIT_S):
    """The next picture, whatever number of turns it takes."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        picture = source.read(0.05)
        if picture is not None:
            return picture
    raise AssertionError("no picture came")


@pytest.fixture
def opened():
    """Opens children and closes them after the test."""
    pipes = []

    def open_child(command, request: bytes = b"") -> ChildPipe:
        pipes.append(ChildPipe(command, request))
        return pipes[-1]

    yield open_child
    for pipe in pipes:
        pipe.close()


def test_a_program_that_is_not_there_is_named() -> None:
    with pytest.raises(PipeEndedError, match="no-such-program: No such file"):
        ChildPipe(["no-such-program"])


def test_nothing_within_the_time_is_told_and_loses_nothing(opened, tmp_path: Path) -> None:
    sign = tmp_path / "go on"
    code = f"os.write(1, b'ab')\nwhile not os.path.exists({str(sign)!r}): time.sleep(0.01)\nos.write(1, b'cd')"
    pipe, target = opened(python(code)), bytearray(4)
    view = memoryview(target)
    while bytes(target[:2]) != b"ab":
        assert not pipe.fill(view, 0.05)
    assert not pipe.fill(view, 0.01)
    sign.touch()
    while not pipe.fill(view, 0.05):
        pass
    assert bytes(target) == b"abcd"


def test_the_last_line_of_a_child_is_the_reason_of_its_end(opened) -> None:
    pipe = opened(python(r"print('a'); print('much noise\n' * 1000 + 'no such camera', file=sys.stderr)"))
    os.waitid(os.P_PID, pipe.pid, os.WEXITED | os.WNOWAIT)
    with pytest.raises(PipeEndedError, match=r"^no such camera$"):
        read(BarePictures(pipe, 64, 48, SimClock()))


def test_a_child_that_says_nothing_ends_with_a_reason_too(opened) -> None:
    with pytest.raises(PipeEndedError, match="said nothing"):
        read(BarePictures(opened(["true"]), 64, 48, SimClock()))


def test_noise_on_the_standard_error_neither_blocks_the_child_nor_harms_pictures(opened) -> None:
    code = "[os.write(2, b'x' * 1000) for _ in range(500)]; os.write(1, b'abc' * 256); time.sleep(60)"
    picture = read(BarePictures(opened(python(code)), 16, 16, SimClock(7)))
    assert picture.arrival_ns == 7
    assert picture.image.tobytes() == b"abc" * 256


def test_pictures_follow_each_other_and_do_not_share_memory(opened) -> None:
    code = "[os.write(1, bytes([number]) * 768) for number in range(5)]; time.sleep(60)"
    source = BarePictures(opened(python(code)), 16, 16, SimClock())
    pictures = [read(source).image for _ in range(5)]
    assert [set(picture.ravel()) for picture in pictures] == [{number} for number in range(5)]


def test_a_header_gives_the_size_and_the_stamp_and_any_chunking_is_the_same(opened) -> None:
    image = scene(1, 24, 20)
    message = HEADER.pack(MAGIC, 123456789, 20, 24) + image.tobytes()
    code = f"m = bytes.fromhex('{message.hex()}') * 2\nfor i in range(0, len(m), 501): os.write(1, m[i:i+501])\n"
    source = StampedPictures(opened(python(code + "time.sleep(60)")))
    for picture in (read(source), read(source)):
        assert picture.arrival_ns == 123456789
        assert picture.image.tobytes() == image.tobytes()
        assert picture.image.shape == (20, 24, 3)


@pytest.mark.parametrize(
    "header", [b"\xff" * HEADER.size, HEADER.pack(MAGIC, 0, 0, 16), HEADER.pack(MAGIC, 0, 16, 10**6)]
)
def test_what_is_no_header_ends_the_source_and_takes_no_memory(opened, header: bytes) -> None:
    source = StampedPictures(opened(python(f"os.write(1, bytes.fromhex('{header.hex()}')); time.sleep(60)")))
    with pytest.raises(PipeEndedError, match="expected a picture's header"):
        read(source)


def test_a_child_that_hangs_and_ignores_signals_is_ended_by_closing() -> None:
    code = "signal.signal(signal.SIGTERM, signal.SIG_IGN); os.write(1, b'a'); time.sleep(600)"
    pipe = ChildPipe(python(code))
    while not pipe.fill(memoryview(bytearray(1)), 0.05):
        pass
    pipe.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pipe.pid, 0)
    pipe.close()


def test_what_libraries_print_does_not_get_between_the_pictures() -> None:
    code = (
        "from edgefusion.drivers.camera_capture import private_stdout; out = private_stdout()\n"
        "os.write(1, b'a library'); out.write(b'picture'); out.flush()"
    )
    done = subprocess.run(python(code), capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"picture", b"a library")


def test_the_capturing_child_ends_with_its_parent_even_while_it_hangs() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"http://127.0.0.1:{silent.getsockname()[1]}/"
        command = [sys.executable, "-m", "edgefusion.drivers.camera_capture"]
        child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        with child:
            child.stdin.write(msgspec.json.encode(CameraConfig(source=url)) + b"\n")
            child.stdin.flush()
            connection, _ = silent.accept()
            with connection:
                connection.recv(4096)
                assert child.poll() is None
                child.stdin.close()
                assert child.wait(LIMIT_S) == 0
