# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The link: bytes both ways, deadlines, errors told apart, a stop first, and one user per port."""

from __future__ import annotations

import os
import select
import socket
import subprocess
import sys
import tty
from pathlib import Path

import pytest
import serial

from edgefusion.clock import SimClock
from edgefusion.drivers.backoff import Backoff
from edgefusion.drivers.link import Link, LinkBlockedError, LinkError, LinkLostError, LinkSilentError
from edgefusion.drivers.port_lock import PortBusyError, PortLock
from edgefusion.errors import RefusedError

MS = 1_000_000


class Pty:
    """A port to open (path), and the device's end of it (master)."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.plug_in()

    def plug_in(self) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.path.symlink_to(os.ttyname(self.slave))

    def unplug(self) -> None:
        os.close(self.master)
        os.close(self.slave)
        self.path.unlink()


@pytest.fixture
def pty(tmp_path):
    made = Pty(tmp_path / "ttyROBOT")
    yield made
    if made.path.is_symlink():
        made.unplug()


@pytest.fixture
def make_link(tmp_path):
    made = []

    def make(name, **settings):
        made.append(Link(str(name), 9600, lock_folder=tmp_path, **settings))
        return made[-1]

    yield make
    for link in made:
        link.close()


def test_bytes_go_both_ways(pty, make_link):
    link = make_link(pty.path)
    link.open()
    link.write(b"to the robot")
    assert os.read(pty.master, 100) == b"to the robot"
    os.write(pty.master, b"from it")
    assert link.read(4) == b"from"
    assert link.read(100) == b" it"
    assert link.read(100) == b""


def test_it_tells_how_much_waits_to_be_read(pty, make_link):
    link = make_link(pty.path)
    link.open()
    os.write(pty.master, b"from it")
    assert link.read(3) == b"fro"
    assert link.waiting_bytes == 4
    pty.unplug()
    with pytest.raises(LinkLostError, match="vanished"):
        link.waiting_bytes  # noqa: B018
    assert not link.is_open


def test_a_socket_is_a_port_too(make_link):
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = make_link(f"socket://127.0.0.1:{server.getsockname()[1]}")
        link.open()
        device, _ = server.accept()
        with device:
            link.write(b"there")
            assert device.recv(100) == b"there"
            device.sendall(b"back")
            assert link.read(4) == b"back"
            link.set_baudrate(38400)
        with pytest.raises(LinkLostError, match="vanished"):
            link.read(1)
        assert not link.is_open


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


def test_silence_is_told_from_a_lost_port(pty, make_link):
    clock = SimClock()
    link = make_link(pty.path, clock=clock)
    link.open()
    clock.advance(9000 * MS)
    assert link.read(10) == b""
    link.expect_within(0.25)
    clock.advance(250 * MS)
    assert link.read(10) == b""
    clock.advance(1 * MS)
    with pytest.raises(LinkSilentError, match=r"0\.25 s"):
        link.read(10)


def test_a_byte_ends_the_silence(pty, make_link):
    clock = SimClock()
    link = make_link(pty.path, clock=clock)
    link.open()
    link.expect_within(0.25)
    clock.advance(900 * MS)
    os.write(pty.master, b"!")
    assert link.read(1) == b"!"
    clock.advance(200 * MS)
    assert link.read(1) == b""


def test_a_limit_of_silence_ends_with_the_port_that_it_was_set_for(pty, make_link):
    clock = SimClock()
    link = make_link(pty.path, clock=clock)
    link.open()
    link.expect_within(0.25)
    clock.advance(300 * MS)
    with pytest.raises(LinkSilentError):
        link.read(1)
    link.open()
    clock.advance(9000 * MS)
    assert link.read(1) == b""


def test_bytes_that_came_while_the_process_was_halted_are_no_silence(pty, make_link):
    clock = SimClock()
    halts = []

    def clock_of_a_process() -> int:
        while halts:  # between the reading that found nothing and its end
            os.write(pty.master, halts.pop())
            assert select.select([pty.slave], [], [], 5)[0]  # until the kernel has passed it on
            clock.advance(1000 * MS)
        return clock()

    link = make_link(pty.path, clock=clock_of_a_process)
    link.open()
    link.expect_within(0.25)
    halts.append(b"from it")
    assert link.read(7) == b""
    assert link.read(7) == b"from it"


def test_a_peer_that_does_not_read_blocks_nobody(pty, make_link):
    link = make_link(pty.path)
    link.open()
    with pytest.raises(LinkBlockedError, match="took no bytes"):
        link.write(bytes(1_000_000))
    with pytest.raises(LinkLostError, match="not open"):
        link.write(b"more")


def test_the_speed_stays_when_the_port_is_opened_again(pty, make_link):
    link = make_link(pty.path)
    link.open()
    link.set_baudrate(38400)
    link.close()
    link.open()
    assert link.baudrate == 38400
    with pytest.raises(RefusedError, match="got -1"):
        link.set_baudrate(-1)


def test_discarded_input_is_gone(pty, make_link):
    link = make_link(pty.path)
    link.open()
    os.write(pty.master, b"stale")
    link.discard_input()
    os.write(pty.master, b"new")
    assert link.read(3) == b"new"


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


def test_what_was_written_last_still_arrives_when_the_link_is_closed(pty, make_link):
    link = make_link(pty.path)
    link.open()
    link.write(b"stop")
    link.close()
    os.set_blocking(pty.master, False)
    assert os.read(pty.master, 100) == b"stop"
