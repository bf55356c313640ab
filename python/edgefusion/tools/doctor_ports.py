# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the devices' files are there, may be opened, and are held by nobody."""

from __future__ import annotations

import errno
import grp
import os
import pwd
import stat
from pathlib import Path
from typing import Iterator, Sequence, Tuple

from edgefusion.drivers.camera_open import device_path
from edgefusion.drivers.port_lock import PortBusyError, PortLock
from edgefusion.errors import RefusedError
from edgefusion.tools.doctor_finding import END_IT, HOLDER, Examination, Finding, State
from edgefusion.tools.doctor_holders import holders_of

TTYS = Path("/sys/class/tty")

_SERIAL = ("ttyUSB*", "ttyACM*", "ttyTHS*", "ttyS[0-9]*")
_VIDEO = ("video*",)
_NAMES = "docs/wiring.md says how to give it a name that stays"


def check_ports(exam: Examination) -> Iterator[Finding]:
    """Of robot, laser and camera; what cannot be used is not asked by the checks after this one."""
    devices = list(_devices(exam))
    for name, port in devices:
        text, cure = _camera_problem(Path(port)) if name == "camera" else _serial_problem(port, exam.lock_folder)
        if text:
            exam.unusable.add(port)
            yield Finding("ports", State.FAILED, f"{name}: {port}: {text}", cure)
        else:
            yield _usable(name, port)
    if not devices:
        yield Finding("ports", State.SKIPPED, "no device is on this machine")


def _devices(exam: Examination) -> Iterator[Tuple[str, str]]:
    """Name and port of those that this machine is to open."""
    config = exam.config
    if exam.runs("base"):
        yield "robot", config.robot.port
        yield "laser", config.laser.port
    if exam.runs("vision") and config.camera.is_v4l2:
        yield "camera", str(device_path(config.camera))


def _usable(name: str, port: str) -> Finding:
    target = port if "://" in port else os.path.realpath(port)
    text = f"{name}: {port}" + ("" if target == port else f" -> {target}")
    timer = TTYS / Path(target).name / "device/latency_timer"
    if timer.exists() and timer.read_text().strip() not in ("0", "1"):
        cure = f"`echo 1 | sudo tee {timer}`; for good: docs/wiring.md"
        text += f": its adapter holds bytes back for {timer.read_text().strip()} ms"
        return Finding("ports", State.WARNING, text, cure)
    return Finding("ports", State.OK, text)


def _camera_problem(path: Path) -> Tuple[str, str]:
    text, cure = _device_problem(path, _VIDEO)
    return (text, cure) if text else _held(path)


def _serial_problem(port: str, lock_folder: Path | None) -> Tuple[str, str]:
    """What is wrong and what to do; empty where nothing is."""
    if "://" in port:
        return "", ""
    text, cure = _device_problem(Path(port), _SERIAL)
    if text:
        return text, cure
    lock = PortLock(port, HOLDER, lock_folder)
    try:
        lock.acquire()
        return _terminal_problem(port)
    except PortBusyError as error:
        return str(error).partition(": ")[2], END_IT
    except RefusedError as error:
        return str(error), "let this user write that file, or remove it"
    finally:
        lock.release()


def _terminal_problem(port: str) -> Tuple[str, str]:
    try:
        file = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        if error.errno != errno.EBUSY:
            return f"cannot be opened: {error.strerror}", f"look into `dmesg`; {_NAMES}"
        return f"held by {', '.join(holders_of(Path(port))) or 'a process of another user'}", END_IT
    try:
        if not os.isatty(file):
            return "expected a serial port, got another device", _there(_SERIAL)
    finally:
        os.close(file)
    return _held(Path(port))


def _held(path: Path) -> Tuple[str, str]:
    holders = holders_of(path)
    return (f"held by {', '.join(holders)}", END_IT) if holders else ("", "")


def _device_problem(path: Path, patterns: Tuple[str, ...]) -> Tuple[str, str]:
    try:
        status = path.stat()
    except FileNotFoundError:
        return "not there", _there(patterns)
    except OSError as error:
        return f"cannot be looked at: {error.strerror}", _there(patterns)
    if not stat.S_ISCHR(status.st_mode):
        return "expected a device, got a file or a folder", _there(patterns)
    if not os.access(path, os.R_OK | os.W_OK):
        return _forbidden(status.st_gid)
    return "", ""


def _forbidden(group_id: int) -> Tuple[str, str]:
    """Of a device of that group, which this process may not open."""
    user, (group, members) = _user(), _group(group_id)
    text = f"{user} may not open it: it belongs to the group {group}"
    if user in members and group_id not in os.getgroups():
        return text, f"log in again: {user} is in the group {group} only since this login"
    return text, f"`sudo usermod -aG {group} {user}`, and log in again"


def _user() -> str:
    """Its name; its number where it has none, as in a container."""
    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())


def _group(group_id: int) -> Tuple[str, Sequence[str]]:
    """Its name, or number, and its members."""
    try:
        group = grp.getgrgid(group_id)
    except KeyError:
        return str(group_id), ()
    return group.gr_name, group.gr_mem


def _there(patterns: Tuple[str, ...]) -> str:
    found = sorted(str(path) for pattern in patterns for path in Path("/dev").glob(pattern))
    if not found:
        return "plug it in and switch it on: no such device is there; `dmesg` says why"
    return f"there are {', '.join(found)}; {_NAMES}"
