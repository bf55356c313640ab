# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A child's line to its supervisor: it carries what is said, never waits, and tells when the supervisor is gone."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from typing import Iterator, Tuple

import msgspec
import pytest

from edgefusion.clock import SimClock
from edgefusion.errors import RefusedError
from edgefusion.service import heartbeat
from edgefusion.service.heartbeat import EVERY_NS, MAX_BYTES, Heartbeat, from_environment
from edgefusion.types import Health, HealthState

Line = Tuple[socket.socket, Heartbeat, SimClock]
WELL = {"says": "drives"}


@pytest.fixture
def line() -> Iterator[Line]:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.setblocking(False)
    theirs.setblocking(False)
    clock = SimClock(1)
    with ours, theirs:
        yield ours, Heartbeat(theirs, clock), clock


def heard(ours: socket.socket) -> list[dict[str, object]]:
    messages = []
    while True:
        try:
            messages.append(json.loads(ours.recv(MAX_BYTES)))
        except BlockingIOError:
            return messages


def test_a_status_is_sent_when_it_changes_and_else_now_and_then(line: Line) -> None:
    ours, beats, clock = line
    for status in (WELL, WELL, {"baudrate": 38400}, WELL):
        beats.beat(status)
    assert heard(ours) == [WELL, {"baudrate": 38400}, WELL]
    clock.advance(EVERY_NS - 1)
    beats.beat(WELL)
    assert heard(ours) == []
    clock.advance(1)
    beats.beat(WELL)
    assert heard(ours) == [WELL]


def test_a_supervisor_that_does_not_read_holds_nobody_up(line: Line) -> None:
    ours, beats, _ = line
    for number in range(2000):
        beats.beat({"n": number})
    assert 0 < len(heard(ours)) < 2000
    assert not beats.parent_gone()
    beats.beat({"n": -1})
    assert heard(ours) == [{"n": -1}]


def test_a_status_that_was_not_taken_is_sent_again(line: Line) -> None:
    ours, beats, _ = line
    for number in range(2000):
        beats.beat({"n": number})
    heard(ours)
    beats.beat({"n": 1999})
    assert heard(ours) == [{"n": 1999}]


def test_a_supervisor_that_is_gone_is_noticed_and_disturbs_nobody(line: Line) -> None:
    ours, beats, _ = line
    assert not beats.parent_gone()
    ours.close()
    beats.beat(WELL)
    assert beats.parent_gone()
    assert beats.others() == ()


def test_it_hears_how_the_other_processes_are(line: Line) -> None:
    ours, beats, _ = line
    assert beats.others() == ()
    first = (Health("vision", HealthState.STARTING, "starts"),)
    second = (Health("vision", HealthState.FAILED, "given up"), Health("bus", HealthState.OK))
    for healths in (first, second):
        ours.send(msgspec.json.encode(healths))
    assert beats.others() == second
    assert beats.others() == second


def test_a_status_that_is_too_long_is_refused(line: Line) -> None:
    with pytest.raises(RefusedError, match="up to 16384 bytes"):
        line[1].beat({"says": "x" * MAX_BYTES})


def test_alone_nobody_is_told_anything() -> None:
    alone = from_environment({})
    alone.beat(WELL)
    assert not alone.supervised and not alone.parent_gone() and alone.others() == ()


@pytest.mark.parametrize("text", ["", "x", "-1", "999", "1e3", str(2**80)])
def test_what_is_no_line_is_refused(text: str) -> None:
    with pytest.raises(RefusedError, match=heartbeat.ENVIRONMENT):
        from_environment({heartbeat.ENVIRONMENT: text})


def test_another_kind_of_socket_is_refused_and_left_open() -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    with ours, theirs:
        with pytest.raises(RefusedError, match="another kind of socket"):
            from_environment({heartbeat.ENVIRONMENT: str(theirs.fileno())})
        assert theirs.send(b"!") == 1


CHILD = """
import os, signal, sys
from edgefusion.service.heartbeat import ENVIRONMENT, from_environment
beats = from_environment()
beats.beat({"env": ENVIRONMENT in os.environ, "inherited": os.get_inheritable(beats._socket.fileno())})
signal.pause()
"""
PARENT = """
import os, signal, socket, subprocess, sys
ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
environment = {**os.environ, "EDGEFUSION_HEARTBEAT_FD": str(theirs.fileno())}
child = subprocess.Popen([sys.executable, "-c", sys.argv[1]], pass_fds=[theirs.fileno()], env=environment)
print(child.pid, ours.recv(1000).decode(), flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_kernel_ends_a_child_whose_supervisor_was_killed() -> None:
    parent = subprocess.Popen([sys.executable, "-c", PARENT, CHILD], stdout=subprocess.PIPE, text=True)
    pid, status = parent.stdout.readline().split(" ", 1)
    try:
        assert parent.communicate(timeout=60)[0] == ""  # it comes to its end when the child, which has it too, ends
    except subprocess.TimeoutExpired:
        os.kill(int(pid), signal.SIGKILL)
        raise
    assert parent.returncode == -signal.SIGKILL
    assert json.loads(status) == {"env": False, "inherited": False}
