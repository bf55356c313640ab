# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The link: bytes both ways, deadlines, and errors told apart."""

from __future__ import annotations

import os
import select
import socket

import pytest

from edgefusion.clock import SimClock
from edgefusion.drivers.link import LinkBlockedError, LinkLostError, LinkSilentError
from edgefusion.errors import RefusedError
from link_scenes import MS, make_link, pty

__all__ = ["make_link", "pty"]


def passed_on(end: int) -> int:
    """That end of a pty, as soon as the kernel, which does it in its own time, has passed on what was written."""
    assert select.select([end], [], [], 30)[0]
    return end


def test_bytes_go_both_ways(pty, make_link):
    link = make_link(pty.path)
    link.open()
    link.write(b"to the robot")
    assert os.read(pty.master, 100) == b"to the robot"
    os.write(pty.master, b"from it")
    passed_on(pty.slave)
    assert link.read(4) == b"from"
    assert link.read(100) == b" it"
    assert link.read(100) == b""


def test_it_tells_how_much_waits_to_be_read(pty, make_link):
    link = make_link(pty.path)
    link.open()
    os.write(pty.master, b"from it")
    passed_on(pty.slave)
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
    passed_on(pty.slave)
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
            passed_on(pty.slave)
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
    passed_on(pty.slave)
    link.discard_input()
    os.write(pty.master, b"new")
    passed_on(pty.slave)
    assert link.read(3) == b"new"


def test_what_was_written_last_still_arrives_when_the_link_is_closed(pty, make_link):
    link = make_link(pty.path)
    link.open()
    link.write(b"stop")
    link.close()
    assert os.read(passed_on(pty.master), 100) == b"stop"
