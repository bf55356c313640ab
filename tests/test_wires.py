# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated device says and hears through a pty and through TCP; the time is the test's own, the ports real."""

from __future__ import annotations

import os
import socket
import termios
import time
from pathlib import Path
from typing import Callable

import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.sim.wire_line import PacedLine
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer
from edgefusion.sim.wire_tcp import TcpWire

MS = 1_000_000


class Parrot:
    """Says after a client what it understood, as fast as its line lets it."""

    def __init__(self, baudrate: int = 38400) -> None:
        self.line = PacedLine(baudrate)
        self.heard = b""

    def receive(self, data: bytes, baudrate: int | None, now_ns: int) -> None:
        self.heard += self.line.heard(data, baudrate)
        self.line.put(self.line.heard(data, baudrate), now_ns)

    def transmit(self, baudrate: int | None, now_ns: int) -> bytes:
        return self.line.heard(self.line.take(now_ns), baudrate)


class Served:
    """A parrot on some wires, pumped until something is so. Every pump is a millisecond of its time."""

    def __init__(self, *wires) -> None:
        self.parrot, self.now_ns = Parrot(), 0
        self.server = WireServer([(self.parrot, wires)])

    def pump(self, until: Callable[[], object] | None = None) -> object:
        """What it was in the end; without a condition, as long as bytes need to arrive."""
        for _ in range(2000 if until else 20):
            self.now_ns += MS
            self.server.pump(self.now_ns)
            found = until() if until else None
            if found:
                return found
            time.sleep(0.0005)
        return None


@pytest.fixture
def pty():
    wire = PtyWire()
    yield wire
    wire.close()


@pytest.fixture
def tcp():
    wire = TcpWire(0)
    yield wire
    wire.close()


def client_of(wire: PtyWire | TcpWire, baudrate: int = 38400) -> serial.SerialBase:
    return serial.serial_for_url(wire.name, baudrate, timeout=0, write_timeout=1)


def connect(wire: TcpWire) -> socket.socket:
    return socket.create_connection(("127.0.0.1", wire.port), timeout=5)


def said(served: Served, client: serial.SerialBase, count: int) -> bytes:
    heard = bytearray()

    def whole() -> bool:
        heard.extend(client.read(100))
        return len(heard) >= count

    served.pump(whole)
    return bytes(heard)


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_client_and_device_hear_each_other(kind: str, request) -> None:
    wire = request.getfixturevalue(kind)
    served = Served(wire)
    with client_of(wire) as client:
        client.write(bytes(range(256)))
        assert said(served, client, 256) == bytes(range(256))


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_one_client_after_another_is_served(kind: str, request) -> None:
    wire = request.getfixturevalue(kind)
    served = Served(wire)
    for number in range(3):
        with client_of(wire) as client:
            client.write(b"I am %d" % number)
            assert said(served, client, 6) == b"I am %d" % number


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_what_a_client_says_last_still_arrives_after_it_has_left(kind: str, request) -> None:
    wire = request.getfixturevalue(kind)
    served = Served(wire)
    with client_of(wire) as client:
        client.write(b"hello")
        said(served, client, 5)
        client.write(b" stop")
    assert served.pump(lambda: served.parrot.heard == b"hello stop")


@pytest.mark.parametrize("baudrate", [4800, 9600, 19200, 57600, 115200, 230400, 500000])
def test_at_another_speed_both_hear_noise(pty: PtyWire, baudrate: int) -> None:
    served = Served(pty)
    with client_of(pty, baudrate) as client:
        client.write(b"hello")
        noise = said(served, client, 5)
        assert len(noise) == 5 and noise != b"hello" and served.parrot.heard not in (b"", b"hello")
        client.baudrate = served.parrot.line.baudrate
        client.write(b"hello")
        assert said(served, client, 5) == b"hello"


def test_what_is_said_while_nobody_listens_is_lost(pty: PtyWire, tcp: TcpWire) -> None:
    served = Served(pty, tcp)
    served.parrot.line.put(b"early", served.now_ns)
    served.pump()
    descriptor = os.open(pty.name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)  # pyserial would forget it, too
    try:
        with pytest.raises(BlockingIOError):
            os.read(descriptor, 10)
    finally:
        os.close(descriptor)
    with client_of(tcp) as client:
        served.parrot.line.put(b"late", served.now_ns)
        assert said(served, client, 4) == b"late"


def test_all_wires_of_a_device_say_the_same(pty: PtyWire, tcp: TcpWire) -> None:
    served = Served(pty, tcp)
    with client_of(pty) as one, client_of(tcp) as other:
        served.pump()
        one.write(b"hello")
        assert (said(served, one, 5), said(served, other, 5)) == (b"hello", b"hello")


def test_a_client_that_does_not_read_holds_up_nobody(pty: PtyWire, tcp: TcpWire) -> None:
    served = Served(pty, tcp)
    with client_of(pty), client_of(tcp):
        served.pump()
        for _ in range(100):
            served.parrot.line.put(bytes(100_000), served.now_ns)
            served.now_ns += 60_000 * MS
            served.server.pump(served.now_ns)
        assert not served.parrot.line.busy


def test_over_tcp_the_second_client_waits_until_the_first_has_left(tcp: TcpWire) -> None:
    served = Served(tcp)
    first, second = connect(tcp), connect(tcp)
    with second:
        with first:
            first.sendall(b"first")
            assert served.pump(lambda: served.parrot.heard == b"first")
            second.sendall(b"second")
            served.pump()
            assert served.parrot.heard == b"first"
        served.pump()
        assert served.parrot.heard == b"firstsecond"
        assert second.recv(6) == b"second"


def test_a_client_that_is_torn_away_leaves_the_port_to_the_next(tcp: TcpWire) -> None:
    served = Served(tcp)
    torn = connect(tcp)
    torn.sendall(b"hello")
    assert served.pump(lambda: served.parrot.heard and not served.parrot.line.busy)
    torn.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
    torn.close()  # a reset, not an end
    with client_of(tcp) as client:
        client.write(b" again")
        assert said(served, client, 6) == b" again"


def test_a_link_leads_to_the_pty_and_goes_with_it(tmp_path: Path) -> None:
    link = tmp_path / "dev" / "robot"
    for _ in range(2):  # unplugged, and plugged in again
        wire = PtyWire(link)
        assert wire.name == str(link) and link.is_symlink()
        served = Served(wire)
        with client_of(wire) as client:
            client.write(b"hello")
            assert said(served, client, 5) == b"hello"
            wire.close()
            assert not link.exists() and not link.is_symlink()
            with pytest.raises((OSError, termios.error)):
                while True:
                    client.write(b"gone?")
        served.server.pump(served.now_ns)


def test_a_link_that_a_killed_one_left_is_replaced_and_a_file_is_not(tmp_path: Path) -> None:
    link, file = tmp_path / "robot", tmp_path / "file"
    link.symlink_to("/dev/pts/none")
    PtyWire(link).close()
    file.write_text("mine")
    with pytest.raises(RefusedError, match="file: expected a place for a link, got File exists"):
        PtyWire(file)
    assert file.read_text() == "mine"


def test_a_port_that_is_taken_is_refused_by_its_number(tcp: TcpWire) -> None:
    with pytest.raises(RefusedError, match=f"port {tcp.port}: expected one that is free, got"):
        TcpWire(tcp.port)


@given(st.lists(st.tuples(st.binary(max_size=40), st.integers(0, 40 * MS)), max_size=20), st.integers(1, 6))
def test_a_line_loses_nothing_and_is_never_faster_than_its_speed(said_then, step_ms: int) -> None:
    line, now_ns, taken, sent = PacedLine(9600), 0, b"", b""
    for data, wait_ns in said_then:
        line.put(data, now_ns)
        sent += data
        end_ns = now_ns + wait_ns
        while now_ns < end_ns:
            now_ns = min(end_ns, now_ns + step_ms * MS)
            taken += line.take(now_ns)
        assert len(taken) * 10 / 9600 <= now_ns / 1e9 + 1e-9
    assert sent.startswith(taken)
    whole_ns = len(sent) * 1_100_000
    assert taken + line.take(now_ns + whole_ns) == sent and not line.busy


def test_a_byte_at_9600_baud_takes_a_little_more_than_a_millisecond() -> None:
    line = PacedLine(9600)
    line.put(b"ab", 0)
    assert [line.take(ns) for ns in (1_041_000, 1_042_000, 2_083_000, 2_084_000)] == [b"", b"a", b"", b"b"]
