# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the computer itself will do: its clock, its disks, and who may what."""

from __future__ import annotations

import os
import re
import shutil
import stat
import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, Iterator

import edgefusion
from edgefusion.bus.clock_id import BOOT_ID
from edgefusion.clock import Clock, system_clock
from edgefusion.tools.doctor_finding import Examination, Finding, State

_SLEEPS, _SLEEP_S, _LATE_S = 50, 0.01, 0.02
_LEAST_BYTES, _FEW_BYTES = 500_000_000, 2_000_000_000
"""What a recording leaves free, and room for one."""


def check_clock(
    exam: Examination,
    clock: Clock = system_clock,
    utc_ns: Clock = time.time_ns,
    pause: Callable[[float], None] = time.sleep,
    boot_id: Path = BOOT_ID,
) -> Iterator[Finding]:
    """Of the clock that everything is stamped with, the wall's, and how punctual the computer is."""
    if not boot_id.exists():
        text = f"{boot_id}: expected the name of this clock, got none"
        yield Finding("clock", State.FAILED, text, "mount /proc: stamps of two computers cannot be told apart")
        return
    installed_ns = Path(edgefusion.__file__).stat().st_mtime_ns
    if utc_ns() < installed_ns:
        text = f"it is {_date(utc_ns())}, before this program was installed ({_date(installed_ns)})"
        cure = "set it (`sudo timedatectl set-ntp true`, or `date -s`): ROS tools and recordings would show that time"
        yield Finding("clock", State.WARNING, text, cure)
    late_s = _lateness_s(clock, pause)
    if late_s > _LATE_S:
        text = f"it is late by {late_s * 1e3:.0f} ms now and then"
        yield Finding("clock", State.WARNING, text, "end what else keeps the processors busy")
    else:
        yield Finding("clock", State.OK, f"{_date(utc_ns())} UTC, late by {late_s * 1e3:.1f} ms at most")


def _lateness_s(clock: Clock, pause: Callable[[float], None]) -> float:
    worst_ns = 0
    for _ in range(_SLEEPS):
        begin_ns = clock()
        pause(_SLEEP_S)
        worst_ns = max(worst_ns, clock() - begin_ns)
    return worst_ns / 1e9 - _SLEEP_S


def _date(ns: int) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.gmtime(ns / 1e9))


def check_disk(exam: Examination, free_bytes: Callable[[Path], int] | None = None) -> Iterator[Finding]:
    """Of the disks with the configuration, the current folder, temporary files and pictures of inspections."""
    free = free_bytes or (lambda path: shutil.disk_usage(path).free)
    folders: Dict[int, Path] = {}
    for path in (exam.path.resolve().parent, Path.cwd(), Path(tempfile.gettempdir()), *_inspections(exam)):
        folders.setdefault(path.stat().st_dev, path)
    for path in folders.values():
        left = free(path)
        text, cure = f"{path}: {left / 1e9:.1f} GB free", "make room; recordings leave 0.5 GB free"
        if left < _LEAST_BYTES:
            yield Finding("disk", State.FAILED, text, cure)
        elif left < _FEW_BYTES:
            yield Finding("disk", State.WARNING, text, cure)
        else:
            yield Finding("disk", State.OK, text)


def check_permissions(exam: Examination, user_id: int | None = None) -> Iterator[Finding]:
    """Who may change the configuration, read what is secret in it, lock the ports, and keep inspections."""
    found = [*_of_configuration(exam), *_of_locks(exam), *_of_inspections(exam)]
    if (os.geteuid() if user_id is None else user_id) == 0:
        cure = "run this as the user of the service: `sudo -u USER edgefusion doctor ...`"
        found.append(Finding("permissions", State.WARNING, "root may everything: this says nothing of others", cure))
    yield from found or [Finding("permissions", State.OK, "nobody else may change the configuration")]


def _of_configuration(exam: Examination) -> Iterator[Finding]:
    mode = exam.path.stat().st_mode
    if mode & stat.S_IWOTH:
        text = f"{exam.path}: everybody may change what the robot does"
        yield Finding("permissions", State.FAILED, text, f"`chmod o-w {exam.path}`")
    source = str(exam.config.camera.source)
    if mode & stat.S_IROTH and re.search(r"//[^/@]*@", source):
        text = f"{exam.path}: everybody may read the password of the camera"
        yield Finding("permissions", State.FAILED, text, f"`chmod o-r {exam.path}`")


def _of_locks(exam: Examination) -> Iterator[Finding]:
    folder = exam.lock_folder or Path(tempfile.gettempdir())
    if not os.access(folder, os.W_OK | os.X_OK):
        text = f"{folder}: expected a folder for the ports' locks, which this user may write"
        yield Finding("permissions", State.FAILED, text, f"`sudo chmod 1777 {folder}`, or set TMPDIR")


def _of_inspections(exam: Examination) -> Iterator[Finding]:
    for place in _inspections(exam):
        if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
            text = f"{exam.config.mission.inspections}: expected a folder for inspections, which this user may write"
            yield Finding(
                "permissions", State.FAILED, text, "make it, and let this user have it; or set [mission] inspections"
            )


def _inspections(exam: Examination) -> Iterator[Path]:
    """Where base keeps them, as far as that is there already."""
    folder = exam.config.mission.inspections
    if folder is not None and exam.runs("base"):
        yield next(path for path in (Path(folder).absolute(), *Path(folder).absolute().parents) if path.exists())
