# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Opening a port: what cannot be opened says why, one user per port, and when to try again."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
import serial

from edgefusion.drivers.backoff import Backoff
from edgefusion.drivers.link import LinkError, LinkLostError
from edgefusion.drivers.port_lock import PortBusyError, PortLock
from edgefusion.errors import RefusedError
from link_scenes import MS, make_link, pty

__all__ = ["make_link", "pty"]


def test_a_port_that_vanished_can_be_opened_when_it_is_there_again(pty, make_link):
    link = make_link(pty.path)
    link.open()
    pty.unplug()
    with pytest.raises(LinkLostError, match="vanished"):
        link.read(1)
    with pytest.raises(LinkLostError, match="cannot be opened"):
        link.open()
    pty.plug_in()
    link.open()
    link.write(b"here again")
    assert os.read(pty.master, 100) == b"here again"


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("/dev/no-such-port", "No such file or directory"),
        ("/dev/null", "Inappropriate ioctl for device"),
        ("socket://127.0.0.1:1", "Connection refused"),
    ],
)
def test_what_cannot_be_opened_is_named_once_with_the_reason(make_link, name, why):
    with pytest.raises(LinkLostError) as lost:
        make_link(name).open()
    assert str(lost.value) == f"{name}: cannot be opened: {why}"


def test_a_port_that_another_program_holds_says_so(pty, make_link):
    with serial.Serial(str(pty.path), exclusive=True), pytest.raises(LinkLostError, match="another program holds it"):
        make_link(pty.path).open()


@pytest.mark.parametrize(
    "name", ["socket://host", "socket://host:", "socket://:8101", "socket://host:port", "socket://host:70000"]
)
def test_an_address_without_a_port_is_refused(make_link, name):
    with pytest.raises(RefusedError, match=f"{name}: expected socket://HOST:PORT"):
        make_link(name).open()


def test_a_second_process_is_refused_with_the_holders_name(pty, make_link, tmp_path):
    make_link(pty.path, holder="edgefusion base").open()
    code = (
        "import sys; from pathlib import Path; from edgefusion.drivers.link import Link; "
        "Link(sys.argv[1], 9600, lock_folder=Path(sys.argv[2])).open()"
    )
    done = subprocess.run([sys.executable, "-c", code, str(pty.path), str(tmp_path)], capture_output=True, text=True)
    assert done.returncode != 0
    assert f"held by edgefusion base (pid {os.getpid()})" in done.stderr


def test_the_lock_is_kept_while_the_port_is_lost_and_given_back_on_close(pty, make_link, tmp_path):
    link = make_link(pty.path, holder="first")
    link.open()
    port = os.path.realpath(pty.path)
    pty.unplug()
    with pytest.raises(LinkError):
        link.read(1)
    other = PortLock(port, "second", tmp_path)
    with pytest.raises(PortBusyError, match="held by first"):
        other.acquire()
    link.close()
    other.acquire()
    other.release()


def test_two_names_of_a_device_are_one_port(tmp_path):
    (tmp_path / "device").touch()
    (tmp_path / "alias").symlink_to(tmp_path / "device")
    first = PortLock(str(tmp_path / "device"), "first", tmp_path)
    first.acquire()
    with pytest.raises(PortBusyError, match="first"):
        PortLock(str(tmp_path / "alias"), "second", tmp_path).acquire()
    first.release()


def test_a_device_that_has_another_number_after_it_was_plugged_in_again_is_locked_by_that(tmp_path):
    for name in ("ttyUSB0", "ttyUSB1"):
        (tmp_path / name).touch()
    by_id = tmp_path / "by-id"
    by_id.symlink_to(tmp_path / "ttyUSB0")
    first = PortLock(str(by_id), "first", tmp_path)
    first.acquire()
    by_id.unlink()
    by_id.symlink_to(tmp_path / "ttyUSB1")
    first.acquire()
    with pytest.raises(PortBusyError, match="held by first"):
        PortLock(str(tmp_path / "ttyUSB1"), "second", tmp_path).acquire()
    other = PortLock(str(tmp_path / "ttyUSB0"), "second", tmp_path)
    other.acquire()
    for lock in (first, other):
        lock.release()


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(RefusedError, match="lock file"):
        PortLock("/dev/ttyS0", "me", tmp_path / "absent").acquire()


def test_the_waits_double_to_the_longest_and_start_anew_after_success():
    backoff, now_ns, waits_ms = Backoff(), 0, []
    assert backoff.due(0)
    for _ in range(7):
        backoff.failed(now_ns)
        wait_ms = next(ms for ms in range(2000) if backoff.due(now_ns + ms * MS))
        waits_ms.append(wait_ms)
        now_ns += wait_ms * MS
    assert waits_ms == [50, 100, 200, 400, 800, 1000, 1000]
    backoff.reset()
    assert backoff.due(now_ns)
