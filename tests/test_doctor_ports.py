# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the doctor says of ports that are not there, are no ports, may not be opened, or are held."""

from __future__ import annotations

import grp
import os
import pwd
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Iterator

import pytest

from doctor_scenes import SEES, examination, told
from edgefusion.drivers.port_lock import PortLock
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.tools import doctor_ports
from edgefusion.tools.doctor_finding import Finding
from edgefusion.tools.doctor_ports import check_ports

BASE_ONLY = {"processes": ("base",)}


@pytest.fixture
def port(tmp_path: Path) -> Iterator[str]:
    """A serial port that nobody has."""
    wire = PtyWire(tmp_path / "good")
    yield wire.name
    wire.close()


def of_the_robot(folder: Path, port: str) -> tuple[Finding, bool]:
    """What is found, and whether the robot will not be asked."""
    exam = examination(folder, robot={"port": port}, laser={"port": "socket://laser:1"}, service=BASE_ONLY)
    robot, laser = check_ports(exam)
    assert told([laser]) == ["ok ports"]
    assert robot.text.startswith(f"robot: {port}")
    return robot, port in exam.unusable


def test_a_good_port_is_told_with_what_it_leads_to(tmp_path: Path, port: str) -> None:
    finding, unusable = of_the_robot(tmp_path, port)
    assert told([finding]) == ["ok ports"]
    assert finding.text == f"robot: {port} -> {os.path.realpath(port)}"
    assert not unusable


@pytest.mark.parametrize(
    ("port", "text", "cure"),
    [
        ("/dev/no-such-port", "not there", ""),
        ("/dev/null", "expected a serial port, got another device", ""),
        ("/tmp", "expected a device, got a file or a folder", ""),
        ("/dev/null/x", "cannot be looked at: Not a directory", ""),
    ],
)
def test_what_is_no_port_is_said_to_be_none(tmp_path: Path, port: str, text: str, cure: str) -> None:
    finding, unusable = of_the_robot(tmp_path, port)
    assert told([finding]) == ["failed ports"]
    assert finding.text == f"robot: {port}: {text}"
    assert "plug it in" in finding.cure or "docs/wiring.md" in finding.cure
    assert unusable


def test_a_link_whose_adapter_is_unplugged_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "robot").symlink_to(tmp_path / "unplugged")
    finding, _ = of_the_robot(tmp_path, str(tmp_path / "robot"))
    assert finding.text.endswith(": not there")


def test_a_port_that_another_edgefusion_holds_is_told_with_its_name(tmp_path: Path, port: str) -> None:
    lock = PortLock(port, "edgefusion base", tmp_path)
    lock.acquire()
    finding, unusable = of_the_robot(tmp_path, port)
    lock.release()
    assert finding.text.endswith(f"it is held by edgefusion base (pid {os.getpid()})")
    assert "end that process" in finding.cure
    assert unusable


@pytest.mark.parametrize("exclusively", ["", "fcntl.ioctl(port, termios.TIOCEXCL);"])
def test_a_port_that_another_program_has_open_is_told_with_its_name(
    tmp_path: Path, port: str, exclusively: str
) -> None:
    code = (
        f"import fcntl, os, sys, termios; port = os.open({port!r}, os.O_RDWR); {exclusively} print(flush=True); input()"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdin is not None and other.stdout is not None
        other.stdout.readline()
        finding, unusable = of_the_robot(tmp_path, port)
        other.stdin.close()
    assert told([finding]) == ["failed ports"]
    assert f" (pid {other.pid})" in finding.text
    assert unusable


@pytest.mark.parametrize(
    ("members", "cure"),
    [
        ([], "`sudo usermod -aG dialout alice`, and log in again"),
        (["alice"], "log in again: alice is in the group dialout only since this login"),
    ],
)
def test_a_port_that_may_not_be_opened_says_whose_it_is_and_how_to_get_in(
    tmp_path: Path, port: str, monkeypatch: pytest.MonkeyPatch, members: list[str], cure: str
) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setattr(os, "getgroups", list)
    monkeypatch.setattr(pwd, "getpwuid", lambda _: SimpleNamespace(pw_name="alice"))
    monkeypatch.setattr(grp, "getgrgid", lambda _: SimpleNamespace(gr_name="dialout", gr_mem=members))
    finding, unusable = of_the_robot(tmp_path, port)
    assert finding.text.endswith("alice may not open it: it belongs to the group dialout")
    assert finding.cure == cure
    assert unusable


def test_a_user_and_a_group_without_names_are_told_by_their_numbers(
    tmp_path: Path, port: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nameless(_: int) -> None:
        raise KeyError

    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setattr(os, "geteuid", lambda: 1234)
    monkeypatch.setattr(pwd, "getpwuid", nameless)
    monkeypatch.setattr(grp, "getgrgid", nameless)
    finding, _ = of_the_robot(tmp_path, port)
    assert f"1234 may not open it: it belongs to the group {Path(port).stat().st_gid}" in finding.text


def test_a_lock_file_that_may_not_be_written_is_named(tmp_path: Path, port: str) -> None:
    PortLock(port, "x", tmp_path).path.mkdir()
    finding, _ = of_the_robot(tmp_path, port)
    assert "expected a lock file that can be written" in finding.text


def test_a_camera_that_is_not_there_is_a_port_too_but_only_where_vision_runs(tmp_path: Path) -> None:
    def found(*processes: str, **camera: Any) -> list[str]:
        exam = examination(tmp_path, **SEES, service={"processes": processes}, camera=camera)
        return [each.text for each in check_ports(exam)]

    assert found("vision", source="/dev/video77") == ["camera: /dev/video77: not there"]
    assert found("vision", source="http://127.0.0.1:1/stream") == ["no device is on this machine"]
    assert found("bus", source="/dev/video77") == ["no device is on this machine"]


@pytest.mark.parametrize(("timer_ms", "state"), [("16", "warning"), ("1", "ok"), ("0", "ok")])
def test_an_adapter_that_holds_bytes_back_is_warned_of(
    tmp_path: Path, port: str, monkeypatch: pytest.MonkeyPatch, timer_ms: str, state: str
) -> None:
    timer = tmp_path / Path(os.path.realpath(port)).name / "device/latency_timer"
    timer.parent.mkdir(parents=True)
    timer.write_text(f"{timer_ms}\n")
    monkeypatch.setattr(doctor_ports, "TTYS", tmp_path)
    finding, unusable = of_the_robot(tmp_path, port)
    assert told([finding]) == [f"{state} ports"]
    assert (f"holds bytes back for {timer_ms} ms" in finding.text) == (state == "warning")
    assert not unusable


def test_looking_leaves_the_port_to_others(tmp_path: Path, port: str) -> None:
    of_the_robot(tmp_path, port)
    PortLock(port, "another", tmp_path).acquire()
