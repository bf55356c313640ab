# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the doctor says of the computer: its clock, its disks, and who may what."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

from doctor_scenes import examination, told
from edgefusion.clock import SimClock
from edgefusion.tools.doctor_machine import check_clock, check_disk, check_permissions

NOW_NS = 4_000_000_000 * 10**9


def punctual(late_s: float = 0.0):
    """A clock, and a pause that ends so late once in a while."""
    clock = SimClock()
    count = [0]

    def pause(seconds: float) -> None:
        count[0] += 1
        clock.advance(round((seconds + (late_s if count[0] % 7 == 0 else 0.0)) * 1e9))

    return clock, pause


@pytest.mark.parametrize(
    ("late_s", "utc_ns", "expected"),
    [
        (0.001, NOW_NS, ["ok clock"]),
        (0.05, NOW_NS, ["warning clock"]),
        (0.001, 1_000_000_000, ["warning clock", "ok clock"]),
    ],
)
def test_a_clock_is_told_with_how_late_it_is_and_whether_its_date_can_be(
    tmp_path: Path, late_s: float, utc_ns: int, expected: list[str]
) -> None:
    clock, pause = punctual(late_s)
    findings = list(check_clock(examination(tmp_path), clock, lambda: utc_ns, pause))
    assert told(findings) == expected
    assert f"late by {late_s * 1e3:.0f}" in findings[-1].text


def test_a_clock_without_a_name_is_a_failure(tmp_path: Path) -> None:
    (finding,) = check_clock(examination(tmp_path), boot_id=tmp_path / "none")
    assert told([finding]) == ["failed clock"]


def test_the_real_clock_can_be_told_of(tmp_path: Path) -> None:
    assert {each.check for each in check_clock(examination(tmp_path))} == {"clock"}


@pytest.mark.parametrize(("free", "state"), [(10**8, "failed"), (10**9, "warning"), (10**10, "ok")])
def test_a_disk_is_told_with_what_is_free(tmp_path: Path, free: int, state: str) -> None:
    findings = list(check_disk(examination(tmp_path), lambda _: free))
    assert set(told(findings)) == {f"{state} disk"}
    assert f"{free / 1e9:.1f} GB free" in findings[0].text


def test_each_disk_is_told_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exam = examination(tmp_path)
    devices = {path.stat().st_dev for path in (tmp_path, Path(tempfile.gettempdir()))}
    assert len(list(check_disk(exam, lambda _: 10**10))) == len(devices)


def test_nothing_to_say_of_permissions_is_said_once(tmp_path: Path) -> None:
    exam = examination(tmp_path)
    exam.path.chmod(0o644)
    assert told(list(check_permissions(exam, user_id=1000))) == ["ok permissions"]


@pytest.mark.parametrize(
    ("mode", "source", "text"),
    [
        (0o646, 0, "everybody may change what the robot does"),
        (0o644, "rtsp://me:secret@camera/1", "everybody may read the password of the camera"),
    ],
)
def test_a_configuration_that_is_too_open_is_a_failure_with_the_command_that_mends_it(
    tmp_path: Path, mode: int, source: object, text: str
) -> None:
    exam = examination(tmp_path, camera={"source": source})
    exam.path.chmod(mode)
    (finding,) = check_permissions(exam, user_id=1000)
    assert told([finding]) == ["failed permissions"]
    assert text in finding.text
    assert "secret" not in finding.text
    assert finding.cure.startswith("`chmod o-")
    exam.path.chmod(0o640)
    assert told(list(check_permissions(exam, user_id=1000))) == ["ok permissions"]


def test_root_is_warned_that_this_says_nothing_of_others(tmp_path: Path) -> None:
    assert told(list(check_permissions(examination(tmp_path), user_id=0))) == ["warning permissions"]


def test_a_folder_for_locks_that_cannot_be_written_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    exam = examination(tmp_path)
    monkeypatch.setattr(os, "access", lambda path, how: False)
    (finding,) = check_permissions(exam, user_id=1000)
    assert told([finding]) == ["failed permissions"]
    assert str(tmp_path) in finding.text


@pytest.mark.parametrize("folder", ["kept", "kept/of/today"])
def test_a_folder_for_inspections_that_can_be_made_is_no_matter(tmp_path: Path, folder: str) -> None:
    exam = examination(tmp_path, mission={"inspections": str(tmp_path / folder)})
    assert told(list(check_permissions(exam, user_id=1000))) == ["ok permissions"]
    assert not (tmp_path / folder).exists()


def test_a_folder_for_inspections_that_base_cannot_write_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a file").touch()
    exam = examination(tmp_path, mission={"inspections": str(tmp_path / "a file/kept")})
    (finding,) = check_permissions(exam, user_id=1000)
    assert told([finding]) == ["failed permissions"]
    assert f"{tmp_path}/a file/kept: expected a folder for inspections" in finding.text
    (tmp_path / "locked").mkdir()
    monkeypatch.setattr(os, "access", lambda path, _: Path(path).name != "locked")
    exam = examination(tmp_path, mission={"inspections": str(tmp_path / "locked/kept")})
    assert told(list(check_permissions(exam, user_id=1000))) == ["failed permissions"]


def test_the_disk_with_inspections_is_looked_at_too(tmp_path: Path) -> None:
    looked: list[Path] = []
    exam = examination(tmp_path, mission={"inspections": "/dev/shm/kept"})
    list(check_disk(exam, lambda path: looked.append(path) or 10**10))
    assert Path("/dev/shm").stat().st_dev in {path.stat().st_dev for path in looked}
