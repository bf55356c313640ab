# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion sim`: what it serves, the real drivers use unchanged, and nothing is left behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

from edgefusion.cli import main
from edgefusion.config import BaseConfig, LaserConfig, PioneerConfig, load_config
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.types import Twist2D
from sim_scenes import skip_without_renderer

LIMIT_S = 60.0


@contextmanager
def served(*options: object, camera: bool = False, start_new_session: bool = False):
    more = [] if camera else ["--no-camera"]
    process = subprocess.Popen(
        [sys.executable, "-m", "edgefusion.cli", "sim", "--json", "--port", "0", *more, *map(str, options)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=start_new_session,
    )
    with process:
        try:
            yield json.loads(process.stdout.readline()), process
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(timeout=20)


def test_its_configuration_is_one_that_run_takes_and_yours_is_not_written_over(tmp_path, capsys) -> None:
    with served("--links", tmp_path, "--for", "1") as (ports, process):
        config = load_config(tmp_path / "robot.toml")
        assert ports["config"] == str(tmp_path / "robot.toml")
        assert config.robot.port == str(tmp_path / "robot")
        assert config.processes == ("bus", "base")  # nothing sees without a camera
        (tmp_path / "calibration.toml").write_text("yours")
        process.wait(LIMIT_S)
    assert [path.name for path in tmp_path.iterdir()] == ["calibration.toml"]
    (tmp_path / "calibration.toml").unlink()
    (tmp_path / "robot.toml").write_text("[robot]\n")
    assert main(["sim", "--no-camera", "--port", "0", "--links", str(tmp_path)]) == 2
    assert "expected a folder without a robot.toml of yours" in capsys.readouterr().err
    assert (tmp_path / "robot.toml").read_text() == "[robot]\n"


def heard(device, poll, is_enough) -> list:
    """What it says until that is enough. A device that a busy machine let be silent for too long is found again, as
    whoever has one does."""
    found, begun, end = [], False, time.monotonic() + LIMIT_S
    while not is_enough(found):
        assert time.monotonic() < end, "it never came to it"
        try:
            if not begun:
                device.start()
            begun = True
            found += poll()
        except LinkError:
            begun = False
    return found


@pytest.mark.parametrize("where", ["robot", "robot_tcp"])
def test_the_pioneer_driver_drives_the_simulated_robot(where: str, tmp_path: Path) -> None:
    with served("--links", tmp_path / "dev") as (ports, _):
        link = Link(ports[where], 9600, lock_folder=tmp_path)
        with Pioneer(link, PioneerConfig(), BaseConfig()) as robot:

            def driven() -> list:
                robot.drive(Twist2D(0.2, 0.0))
                return robot.poll()

            def has_moved(states: list) -> bool:
                return bool(states) and states[-1].motors_enabled and states[-1].odometry.x_m > 0.05

            assert has_moved(heard(robot, driven, has_moved))


def test_the_laser_driver_reads_the_simulated_laser_wherever_it_was_left(tmp_path: Path) -> None:
    with served("--laser-left-at", "38400") as (ports, _):
        laser = Lms2xx(Link(ports["laser"], 9600, lock_folder=tmp_path), LaserConfig(baudrate=500000))
        scans = heard(laser, laser.read, lambda scans: len(scans) > 15)
        laser.close()
    assert {len(scan.ranges_m) for scan in scans} == {361}


def test_the_camera_is_a_stream_of_pictures_with_their_stamps() -> None:
    skip_without_renderer()
    with served(camera=True) as (ports, _), urllib.request.urlopen(ports["camera"], timeout=60) as stream:
        lines = [stream.readline() for _ in range(4)]
    stamps = [int(line.split(b":")[1]) for line in lines if line.startswith(b"X-Timestamp-Ns")]
    assert len(stamps) == 1 and 0 < stamps[0] <= time.monotonic_ns()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_it_ends_with_0_and_leaves_nothing_behind(number: signal.Signals, tmp_path: Path) -> None:
    with served("--links", tmp_path / "dev") as (ports, process):
        assert Path(ports["robot"]).is_symlink() and Path(ports["laser"]).is_symlink()
        process.send_signal(number)
        assert process.wait(timeout=20) == 0 and not process.stderr.read()
    assert list((tmp_path / "dev").iterdir()) == []


def test_ctrl_c_in_a_terminal_ends_its_renderer_without_a_word() -> None:
    skip_without_renderer()
    with served(camera=True, start_new_session=True) as (_, process):
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
        assert process.wait(timeout=20) == 0 and not process.stderr.read()


def test_a_fault_is_there_in_its_time(tmp_path: Path) -> None:
    with served("--laser-left-at", "38400", "--fault", "laser=off@0") as (ports, _):
        link = Link(ports["laser"], 38400, lock_folder=tmp_path)
        link.open()
        silent = [link.read(100) for _ in range(30)]  # each takes 20 ms; well, it says a scan in that time
        link.close()
    assert set(silent) == {b""}


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["nowhere"], "nowhere"),
        (["--fault", "laser=broken"], "expected one of off, stuck"),
        (["--no-camera", "--port", "0", "--fault", "camera=off"], "camera=off: expected a camera, none is served"),
        (["--for", "0"], "--for 0: expected seconds above 0"),
        (["--power-up", "-1"], "--power-up -1: expected seconds of at least 0"),
        (["--port", "70000"], "--port 70000: expected 0 to 65535"),
        (["--seed", "-1"], "--seed -1: expected at least 0"),
    ],
)
def test_what_it_cannot_do_is_refused_with_exit_code_2(options: list[str], why: str, capsys) -> None:
    assert main(["sim", *options]) == 2
    assert why in capsys.readouterr().err


def test_a_taken_port_and_a_taken_place_for_a_link_are_refused(tmp_path: Path, capsys) -> None:
    with served() as (ports, _):
        port = ports["robot_tcp"].rsplit(":", 1)[1]
        assert main(["sim", "--no-camera", "--port", port]) == 2
        assert f"port {port}: expected one that is free" in capsys.readouterr().err
    (tmp_path / "robot").write_text("mine")
    assert main(["sim", "--no-camera", "--port", "0", "--links", str(tmp_path)]) == 2
    assert (tmp_path / "robot").read_text() == "mine"
