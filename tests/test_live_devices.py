# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Devices that are served on ptys, and a laser whose cable comes out and goes in."""

from __future__ import annotations

import os
from pathlib import Path

from edgefusion.sim.live_devices import LiveDevices, LiveSetup
from edgefusion.sim.world import Wall, World
from edgefusion.types import Pose2D

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
