# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Calls that raise when they are told to, and a robot that is commanded all the time meanwhile."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable

import pytest

from base_scenes import MS
from edgefusion.drivers.sip_command import Command
from edgefusion.types import HealthState
from robot_faults import AHEAD, ZEROS, Driven
from virtual_port import VirtualPort

WITHIN_NS = 100 * MS
STOPS = {*ZEROS, (Command.RVEL, 0), (Command.ENABLE, 0), (Command.CLOSE, 1)}
PORTS_CALLS = ("read", "write", "in_waiting", "reset_input_buffer")


class Trap:
    """Counts calls; where it is set, the one with that number raises what no driver should, once. sprung_ns: when."""

    def __init__(self, clock: Callable[[], int]) -> None:
        self._clock, self.calls, self.sprung_ns = clock, 0, 0
        self._number = -1

    def set(self, number: int) -> None:
        """Counted from now on."""
        self._number = self.calls + number

    def on(self, monkeypatch: pytest.MonkeyPatch, owner: type, name: str, lies: Any = lambda _: True) -> Trap:
        """lies: whether a call of that object counts."""
        original: Any = vars(owner)[name]
        is_property = isinstance(original, property)
        call = original.fget if is_property else original

        def trapped(self: Any, *arguments: Any) -> Any:
            if lies(self):
                trap._count()
            return call(self, *arguments)

        trap = self
        monkeypatch.setattr(owner, name, property(trapped) if is_property else trapped)
        return self

    def _count(self) -> None:
        self.calls += 1
        if self.calls - 1 == self._number:
            self.sprung_ns = self._clock()
            raise ZeroDivisionError("oops")


class Commanded:
    """A robot that its base's thread owns, and that is commanded ahead every 50 ms of its own time. calls: of its
    port."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, lasts_s: float = 10.0) -> None:
        self.made = Driven(folder, monkeypatch)
        self.clock = self.made.clock
        self.calls = Trap(self.clock)
        self._advance, self._due_ns, self._end_ns = self.clock.advance, 0, self.clock() + round(lasts_s * 1e9)
        self.clock.advance = self._commands

    def _commands(self, ns: int) -> int:
        now_ns, news = self._advance(ns), self.made.thread.news
        if now_ns >= self._due_ns and news.newest is not None:
            self._due_ns = now_ns + 50 * MS
            self.made.device.drive(now_ns, AHEAD, news.newest.session)
        if now_ns > self._end_ns:
            self.made.thread.end()
        return now_ns

    def at_speed(self) -> Commanded:
        self.made.until(lambda: self.made.robot.body.twist.v_mps > 0.29, 10)
        return self

    def runs(self) -> None:
        """Its thread, until it ends."""
        self.made.thread.run()

    @property
    def last_heard(self) -> tuple[int, tuple[int, int | None]]:
        ns, told = self.made.robot.firmware.heard[-1]
        return ns, (told.number, told.argument)

    def assert_ended_by_a_stop(self) -> None:
        sprung_ns = self.calls.sprung_ns
        assert self.made.thread.news.health.state is HealthState.FAILED
        assert self.made.stopped_after_s(sprung_ns) * 1e9 <= WITHIN_NS
        assert self.last_heard[0] - sprung_ns <= WITHIN_NS
        assert self.last_heard[1] in STOPS
        assert self.made.moved_since(sprung_ns) == []


def trapped_ports(monkeypatch: pytest.MonkeyPatch, it: Commanded) -> Trap:
    for name in PORTS_CALLS:
        it.calls.on(monkeypatch, VirtualPort, name)
    return it.calls
