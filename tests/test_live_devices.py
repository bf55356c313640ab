# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Devices that are served on ptys, and a laser whose cable comes out and goes in."""

from __future__ import annotations

import os
import threading
import time
import urllib.request
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Iterator

import pytest

from camera_scenes import wait_until
from edgefusion.errors import RefusedError
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.live_devices import LiveDevices, LiveSetup
from edgefusion.sim.world import Wall, World
from edgefusion.types import Pose2D
from sim_scenes import skip_without_renderer

CORNERS = ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
WALLS = tuple(Wall(start, end, 2.5, 0.1, "plaster") for start, end in zip(CORNERS, CORNERS[1:] + CORNERS[:1]))
ROOM = World("room", 1, "tiles", None, WALLS, (), Pose2D(), Pose2D(1.0, 0.0))
MS = 1_000_000


def heard(devices: LiveDevices, port: Path, from_ms: int) -> bytes:
    """What comes out of a port within 0.3 s of the devices' time."""
    client = os.open(port, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    data = b""
    try:
        for ms in range(from_ms, from_ms + 300, 10):
            devices.pump(ms * MS)
            try:
                data += os.read(client, 65536)
            except BlockingIOError:
                continue
    finally:
        os.close(client)
    return data


def test_a_laser_that_is_unplugged_is_gone_and_is_heard_again_at_the_same_link(tmp_path: Path) -> None:
    setup = LiveSetup(ROOM, robot_port=0, camera=False, laser_left_at=38400, links=tmp_path)
    devices = LiveDevices(setup, 0)
    try:
        port = tmp_path / "laser"
        assert len(heard(devices, port, 0)) > 800
        devices.unplug_laser()
        devices.pump(400 * MS)
        assert not port.exists()
        devices.plug_laser()
        assert len(heard(devices, port, 500)) > 800
    finally:
        devices.close()
    assert not port.is_symlink()


@contextmanager
def running(devices: LiveDevices) -> Iterator[None]:
    """Their time goes on with the machine's, until all is closed."""
    over = threading.Event()

    def pump() -> None:
        while not over.wait(0.002):
            devices.pump(time.monotonic_ns())

    thread = threading.Thread(target=pump)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        devices.close()


def pictures_of(url: str, wait_s: float) -> list[bytes]:
    """The stamps of those that come, three at most, each within so long; none where the connection takes longer."""
    stamps = []
    with suppress(OSError), urllib.request.urlopen(url, timeout=wait_s) as stream:
        while len(stamps) < 3:
            line = stream.readline()
            stamps += [line] if line.startswith(b"X-Timestamp-Ns") else []
    return stamps


def test_a_camera_is_spoilt_and_mended_while_it_runs() -> None:
    skip_without_renderer()
    devices = LiveDevices(LiveSetup(ROOM, robot_port=0), time.monotonic_ns())
    with running(devices):
        assert devices.pictures is not None
        url = devices.pictures.url + "stream"
        assert len(pictures_of(url, 60.0)) == 3
        devices.inject(parse_fault("camera=off"), time.monotonic_ns())
        newest: list[bytes] = []

        def stands() -> bool:
            """The newest of before is given to whoever comes, and nothing after it."""
            before, newest[:] = newest[:], pictures_of(url, 0.8)
            return len(newest) == 1 and newest == before

        wait_until(stands)
        devices.mend()
        assert len(pictures_of(url, 60.0)) == 3


def test_a_fault_of_a_camera_that_is_not_served_is_refused() -> None:
    devices = LiveDevices(LiveSetup(ROOM, robot_port=0, camera=False), 0)
    try:
        with pytest.raises(RefusedError, match="camera=off: expected a camera, none is served"):
            devices.inject(parse_fault("camera=off"), 0)
    finally:
        devices.close()


def test_faults_may_follow_each_other_without_end() -> None:
    devices = LiveDevices(LiveSetup(ROOM, robot_port=0, camera=False), 0)
    try:
        for ms in range(200):
            devices.inject(parse_fault("laser=garbage"), ms * MS)
            devices.mend()
    finally:
        devices.close()
