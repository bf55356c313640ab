# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What systemd hears: every word once, the watchdog in time, and nothing that holds the service up."""

from __future__ import annotations

import logging
import os
import socket
from pathlib import Path
from typing import Iterator

import pytest

from edgefusion.clock import SimClock
from edgefusion.errors import RefusedError
from edgefusion.service.notify import STATUS_NS, Notifier

S = 1_000_000_000


class Systemd:
    def __init__(self, address: str) -> None:
        self.address = address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(address.replace("@", "\0"))
        self._socket.setblocking(False)

    def heard(self) -> list[str]:
        lines = []
        while True:
            try:
                lines.append(self._socket.recv(4096).decode())
            except BlockingIOError:
                return lines

    def close(self) -> None:
        self._socket.close()


@pytest.fixture(params=["path", "abstract"])
def systemd(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Systemd]:
    made = Systemd(str(tmp_path / "notify") if request.param == "path" else f"@edgefusion-test-{os.getpid()}")
    yield made
    made.close()


@pytest.fixture
def clock() -> SimClock:
    return SimClock(S)


@pytest.fixture
def notifier(systemd: Systemd, clock: SimClock) -> Iterator[Notifier]:
    made = Notifier({"NOTIFY_SOCKET": systemd.address, "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "7"}, clock, 7)
    yield made
    made.close()


def test_ready_and_stopping_are_said_once(systemd: Systemd, notifier: Notifier) -> None:
    for _ in range(3):
        notifier.ready()
        notifier.stopping()
    assert systemd.heard() == ["READY=1", "STOPPING=1"]


def test_what_systemd_did_not_take_at_first_is_said_again(
    systemd: Systemd, notifier: Notifier, clock: SimClock
) -> None:
    def say() -> None:
        clock.advance(STATUS_NS)
        notifier.ready()
        notifier.stopping()
        notifier.status("well")

    for _ in range(10_000):  # until its queue is full
        clock.advance(S)
        notifier.alive()
    say()
    assert set(systemd.heard()) == {"WATCHDOG=1"}
    say()
    say()
    assert systemd.heard() == ["READY=1", "STOPPING=1", "STATUS=well"]


def test_the_watchdog_hears_of_a_live_loop_twice_in_its_time(
    systemd: Systemd, notifier: Notifier, clock: SimClock
) -> None:
    times_s = []
    for _ in range(100):
        notifier.alive()
        times_s += [clock() / S for _ in systemd.heard()]
        clock.advance(S // 20)
    assert times_s == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0])


def test_a_loop_that_does_not_come_by_says_nothing(systemd: Systemd, notifier: Notifier, clock: SimClock) -> None:
    notifier.alive()
    systemd.heard()
    clock.advance(100 * S)
    assert systemd.heard() == []
    notifier.alive()
    assert systemd.heard() == ["WATCHDOG=1"]


def test_a_status_is_one_line_said_when_it_changes_and_the_newest_of_many(
    systemd: Systemd, notifier: Notifier, clock: SimClock
) -> None:
    notifier.status("base ok:\n drives")
    notifier.status("base ok: drives")
    notifier.status("passing")
    notifier.status("base ok: stands")
    assert systemd.heard() == ["STATUS=base ok: drives"]
    clock.advance(STATUS_NS)
    notifier.status("base ok: stands")
    clock.advance(STATUS_NS)
    notifier.status("base ok: stands")
    assert systemd.heard() == ["STATUS=base ok: stands"]


@pytest.mark.parametrize("watchdog", [{}, {"WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "8"}])
def test_without_a_watchdog_of_its_own_it_says_nothing_of_life(
    systemd: Systemd, clock: SimClock, watchdog: dict[str, str]
) -> None:
    made = Notifier({"NOTIFY_SOCKET": systemd.address, **watchdog}, clock, 7)
    made.alive()
    made.ready()
    assert systemd.heard() == ["READY=1"]
    made.close()


def test_without_systemd_it_tells_nobody() -> None:
    made = Notifier({"WATCHDOG_USEC": "2000000"})
    made.ready()
    made.alive()
    made.status("well")
    made.close()


def test_a_systemd_that_does_not_read_or_is_gone_holds_nobody_up(
    systemd: Systemd, notifier: Notifier, clock: SimClock, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        for _ in range(10_000):
            clock.advance(S)
            notifier.alive()
        assert "systemd does not take WATCHDOG=1" in caplog.text
    assert 0 < len(systemd.heard()) < 10_000
    systemd.close()
    notifier.ready()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("NOTIFY_SOCKET", "run/notify"),
        ("WATCHDOG_USEC", "0"),
        ("WATCHDOG_USEC", "-5"),
        ("WATCHDOG_USEC", "2s"),
        ("WATCHDOG_PID", "x"),
    ],
)
def test_what_systemd_does_not_say_so_is_refused(name: str, text: str) -> None:
    with pytest.raises(RefusedError, match=f"^{name}: expected"):
        Notifier({name: text})
