# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion doctor` as it is called: lines, JSON, exit codes, and a whole robot of simulated devices."""

from __future__ import annotations

import json
import os
import re
import signal
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator, Sequence

import pytest

from camera_scenes import wait_until
from edgefusion.cli import main
from edgefusion.drivers.sip_command import Command
from edgefusion.sim.live_devices import LiveDevices, LiveSetup
from edgefusion.sim.world import Wall, World
from edgefusion.tools import doctor
from edgefusion.tools.doctor import EXAMPLES
from edgefusion.tools.doctor_finding import CHECKS, Examination, Finding, State, exit_code
from edgefusion.types import Pose2D

CORNERS = ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
WALLS = tuple(Wall(start, end, 2.5, 0.1, "plaster") for start, end in zip(CORNERS, CORNERS[1:] + CORNERS[:1]))
DOCUMENT = Path(__file__).parents[1] / "docs/doctor.md"
BASE_ONLY = "[service]\nprocesses = ['base']\n"
WELL = [["ok", "ports"], ["ok", "ports"], ["ok", "robot"], ["ok", "laser"]]
ROOM = World("room", 1, "tiles", None, WALLS, (), Pose2D(), Pose2D(1.0, 0.0))


@pytest.fixture(autouse=True)
def own_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ports are locked by name, and another process may still wait for a pty that once had this one's."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


@contextmanager
def served(folder: Path) -> Iterator[LiveDevices]:
    """Robot and laser at folder/robot and folder/laser, in real time."""
    devices = LiveDevices(LiveSetup(ROOM, robot_port=0, camera=False, links=folder), time.monotonic_ns())
    end = threading.Event()

    def pump() -> None:
        while not end.is_set():
            devices.pump(time.monotonic_ns())
            time.sleep(0.002)

    thread = threading.Thread(target=pump)
    thread.start()
    try:
        yield devices
    finally:
        end.set()
        thread.join()
        devices.close()


def configuration(folder: Path, robot: str, laser: str, more: str = "") -> Path:
    path = folder / "robot.toml"
    ports = f"[robot]\nbaudrates = [9600]\nport = '{folder / robot}'\n[laser]\nport = '{folder / laser}'\n"
    path.write_text(ports + more, "utf-8")
    return path


def lines(capsys: pytest.CaptureFixture[str]) -> list[list[str]]:
    """How each finding is and of what, without what to do."""
    return [line.split()[:2] for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]


def only(*checks: str) -> list[str]:
    return [word for check in checks for word in ("--only", check)]


def test_a_robot_that_is_well_is_told_line_by_line_and_has_not_moved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with served(tmp_path) as devices:
        path = configuration(tmp_path, "robot", "laser", BASE_ONLY)
        command = ["doctor", "--config", str(path), *only("ports", "robot", "laser", "clock")]
        for _ in range(5):  # on a busy machine the devices may be silent for too long: it is right to say so
            code, told = main(command), [each for each in lines(capsys) if each[1] != "clock"]
            if (code, told) == (0, WELL):
                break
        assert (code, told) == (0, WELL)
        wait_until(lambda: devices.robot.heard[-1][1].number == Command.CLOSE)  # a pty passes it on in its own time
        heard = [(each.number, each.argument) for _, each in devices.robot.heard]
        pose = devices.world.body.pose
    assert (Command.ENABLE, 1) not in heard
    assert pose == ROOM.start


def test_a_wrong_device_and_a_missing_port_are_told_and_the_first_is_the_exit_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with served(tmp_path):
        path = configuration(tmp_path, "laser", "none", BASE_ONLY)
        code = main(["doctor", "--config", str(path), "--json", *only("ports", "robot", "laser", "camera")])
    shown = json.loads(capsys.readouterr().out)
    assert code == shown["exit_code"] == 10
    told = [(each["check"], each["state"]) for each in shown["findings"]]
    assert told == [
        ("ports", "ok"),
        ("ports", "failed"),
        ("robot", "failed"),
        ("laser", "skipped"),
        ("camera", "skipped"),
    ]
    missing, wrong = shown["findings"][1:3]
    assert missing["text"] == f"laser: {tmp_path / 'none'}: not there"
    assert missing["cure"]
    assert "expected a Pioneer, got no answer" in wrong["text"]
    assert "swapped" in wrong["cure"]


def failed(*checks: str) -> Sequence[Finding]:
    return [Finding(check, State.FAILED if check in checks else State.OK, "x") for check in CHECKS]


@pytest.mark.parametrize("check", CHECKS)
def test_each_check_has_an_exit_code_of_its_own_that_help_and_document_name(check: str) -> None:
    code = exit_code(failed(check))
    assert code == 10 + CHECKS.index(check)
    assert f"{code} {check}" in " ".join(EXAMPLES.split())
    assert f"\n| `{check}` | {code} | " in DOCUMENT.read_text(encoding="utf-8")


def test_the_exit_code_is_of_the_first_check_that_failed_and_0_where_none_did() -> None:
    assert exit_code(failed("disk", "laser", "bus")) == 12
    assert exit_code(failed()) == 0
    assert exit_code([Finding("ports", State.WARNING, "x"), Finding("robot", State.SKIPPED, "x")]) == 0
    assert exit_code([]) == 0


def test_a_configuration_in_which_something_is_wrong_is_refused_before_anything_is_opened(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = configuration(tmp_path, "robot", "laser", "\n[bus]\nlisten = ['tcp/0.0.0.0:7447']\n")
    assert main(["doctor", "--config", str(path)]) == 2
    told = capsys.readouterr()
    assert f"{path}:8: bus: listen: " in told.err and "open to everybody on the network" in told.err
    assert told.out == ""


def test_a_check_that_there_is_not_is_refused_with_those_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = configuration(tmp_path, "robot", "laser")
    assert main(["doctor", "--config", str(path), "--only", "lasr"]) == 2
    assert "--only: expected ports, robot, laser, " in capsys.readouterr().err


@pytest.mark.parametrize("error", [OSError("the other\nvanished"), KeyError("the other vanished")])
def test_a_check_that_cannot_be_made_is_a_failure_and_does_not_end_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], error: Exception
) -> None:
    def broken(exam: Examination) -> Iterator[Finding]:
        yield Finding("disk", State.OK, "one of them")
        raise error

    checks = {**doctor.known_checks(), "disk": broken}
    monkeypatch.setattr(doctor, "known_checks", lambda: checks)
    path = configuration(tmp_path, "robot", "laser")
    assert main(["doctor", "--config", str(path), *only("disk", "permissions")]) == 18
    told = capsys.readouterr().out
    assert re.search("it could not be looked at: .?the other vanished", told)
    assert "permissions" in told


def test_an_examination_that_is_ended_early_is_not_taken_for_all_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def long(exam: Examination) -> Iterator[Finding]:
        os.kill(os.getpid(), signal.SIGTERM)
        yield Finding("disk", State.OK, "after a while")

    monkeypatch.setattr(doctor, "known_checks", lambda: {"disk": long})
    path = configuration(tmp_path, "robot", "laser")
    with pytest.raises(SystemExit) as ended:
        main(["doctor", "--config", str(path), *only("disk")])
    assert ended.value.code == 130


def test_a_whole_examination_of_a_computer_without_a_robot_makes_every_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = configuration(tmp_path, "robot", "laser", "[camera]\nsource = '/dev/video77'\n")
    assert main(["doctor", "--config", str(path)]) == 10
    assert list(dict.fromkeys(check for _, check in lines(capsys))) == list(CHECKS)
