# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot in a live world, as its computer has it: a configuration for its devices, and `edgefusion run` with it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from edgefusion.sim.live_devices import LiveDevices
from edgefusion.tools.sim_config import calibration_text

ENDING_S = 20.0
CONFIG = """[robot]
port = "{robot}"
[laser]
port = "{laser}"
baudrate = {baudrate}
[camera]
source = "{camera}"
[base]
laser_pose = {laser_pose}
[vision]
model = "{model}"
calibration = "calibration.toml"
threads = {threads}
[mission]
interest = []
max_distance_m = {near_m}
stand_s = {stand_s}
last_look_s = {last_look_s}
inspections = "inspections"
[bus]
listen = ["{endpoint}"]
"""


@dataclass(frozen=True)
class RobotSetup:
    """threads: of the network, 0: one for each core. near_m: objects are inspected from no farther."""

    model: Path
    baudrate: int = 500000
    threads: int = 0
    near_m: float = 2.5
    stand_s: float = 10.0
    last_look_s: float = 1.5


def free_endpoint() -> str:
    """A port of this computer that was free a moment ago."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{taken.getsockname()[1]}"


def write_config(folder: Path, devices: LiveDevices, setup: RobotSetup, endpoint: str) -> Path:
    """robot.toml and calibration.toml, for a robot whose devices these are."""
    rig = devices.world.rig
    (folder / "calibration.toml").write_text(calibration_text(rig), encoding="utf-8")
    pose = rig.T_base_laser[:2, 3].tolist()
    assert devices.pictures is not None
    path = folder / "robot.toml"
    path.write_text(
        CONFIG.format(
            robot=devices.robot_pty.name,
            laser=devices.laser_pty.name,
            baudrate=setup.baudrate,
            camera=devices.pictures.url + "stream",
            laser_pose=[*pose, 0.0],
            model=setup.model.resolve(),
            threads=setup.threads,
            near_m=setup.near_m,
            stand_s=setup.stand_s,
            last_look_s=setup.last_look_s,
            endpoint=endpoint,
        ),
        encoding="utf-8",
    )
    return path


class RobotProcess:
    """`edgefusion run` from its making until end(), which says how long that took [s]. Its words go to a file."""

    def __init__(self, config: Path, log: Path, wrapper: Sequence[str] = ()) -> None:
        # Ports are locked where no other robot of this computer is.
        environment = {**os.environ, "TMPDIR": str(config.parent)}
        command = [*wrapper, sys.executable, "-m", "edgefusion.cli", "run", "--config", str(config)]
        self._log = log.open("wb")
        self.started_ns = time.monotonic_ns()
        self._process = subprocess.Popen(command, env=environment, stdout=self._log, stderr=self._log)

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def lives(self) -> bool:
        return self._process.poll() is None

    def end(self) -> float:
        begun_s = time.monotonic()
        self._process.send_signal(signal.SIGTERM)
        try:
            self._process.wait(ENDING_S)
        except subprocess.TimeoutExpired:
            self._process.kill()  # its children hear from the kernel that it is gone
            self._process.wait()
        self._log.close()
        return time.monotonic() - begun_s
