# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Y3: whatever raises in a base, the last that its robot hears is to stop, at once, and nothing moves it any more."""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path
from typing import Callable

import pytest
from threaded_base import ThreadedBase
from trapped import PORTS_CALLS, STOPS, WITHIN_NS, Commanded, Trap, trapped_ports

from base_scenes import CONFIG, MS, WELL
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.service.base import Base
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.cadence import Cadence
from edgefusion.service.device_thread import DeviceThread
from edgefusion.service.ending import Ending
from edgefusion.service.requests import Requests
from edgefusion.service.robot_device import RobotDevice
from edgefusion.types import STILL, Health, HealthState, Twist2D
from virtual_port import VirtualPort


def test_y3_an_error_at_any_call_of_its_port_while_it_drives_stops_the_robot_at_once(tmp_path: Path) -> None:
    sprung = 0
    for number in range(25):  # those of 150 ms: a report and three commands
        with pytest.MonkeyPatch.context() as monkeypatch:
            it = Commanded(tmp_path, monkeypatch).at_speed()
            trapped_ports(monkeypatch, it).set(number)
            it.runs()
            it.assert_ended_by_a_stop()
            sprung += 1
    assert sprung == 25


def test_y3_an_error_at_any_call_of_its_port_while_it_starts_moves_nothing(tmp_path: Path) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        it = Commanded(tmp_path, monkeypatch)
        calls = trapped_ports(monkeypatch, it)
        it.made.until(lambda: not it.made.is_lost, 10)
        it.made.driver.close()
    for number in range(0, calls.calls, 3):
        with pytest.MonkeyPatch.context() as monkeypatch:
            it = Commanded(tmp_path, monkeypatch)
            trapped_ports(monkeypatch, it).set(number)
            it.runs()
            assert it.calls.sprung_ns
            assert not it.made.robot.firmware.open
            assert it.made.moved_since(0) == []
    assert number > 60


def test_y3_an_error_at_any_call_of_its_port_while_it_ends_keeps_the_robot_from_no_stop(tmp_path: Path) -> None:
    number, sprung = 0, True
    while sprung:
        with pytest.MonkeyPatch.context() as monkeypatch:
            it = Commanded(tmp_path, monkeypatch).at_speed()
            trapped_ports(monkeypatch, it).set(number)
            ended_ns = it.clock()
            it.made.thread.end()
            it.runs()
            sprung, number = it.calls.sprung_ns > 0, number + 1
            assert it.last_heard[0] - ended_ns <= WITHIN_NS
            assert it.last_heard[1] in STOPS
            assert not it.made.robot.firmware.open
    assert number > 1


def bump(it: Commanded) -> None:
    it.made.robot.body.bumpers = (False, True, False, False, False), (False,) * 5


def ask_for_motors(it: Commanded) -> None:
    it.made.device.enable_motors()


@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("poll", lambda _: None),
        ("drive", lambda _: None),
        ("health", lambda _: None),
        ("stop", bump),
        ("enable_motors", ask_for_motors),
    ],
)
def test_y3_an_error_at_any_call_of_its_driver_stops_the_robot_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, first: Callable[[Commanded], None]
) -> None:
    it = Commanded(tmp_path, monkeypatch).at_speed()
    it.calls.on(monkeypatch, Pioneer, name).set(0)
    first(it)
    it.runs()
    it.assert_ended_by_a_stop()


@pytest.mark.parametrize("number", [0, 7])
def test_y3_an_error_at_any_call_of_the_lasers_port_stops_the_robot_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    monkeypatch.locks = tmp_path
    base = ThreadedBase(monkeypatch).driving()
    trap = Trap(base.clock)
    for name in PORTS_CALLS:
        trap.on(monkeypatch, VirtualPort, name, lambda port: port._line is base.lines["laser"])
    trap.set(number)
    base.run(0.5)
    assert base.laser_turn.news.health.reason == "closed after ZeroDivisionError: oops"
    first_ns, stands = base.motions_since(trap.sprung_ns)[0]
    assert first_ns - trap.sprung_ns <= WITHIN_NS
    assert stands
    assert base.moved_since(trap.sprung_ns) == []
    base.clock.finish()


class Robot:
    """A driver whose robot stands and reports all the time; told: in order."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.health = WELL["robot"]
        self._ns = 0

    def __getattr__(self, call: str) -> Callable[..., list[RobotState]]:
        def tell(*_: object) -> list[RobotState]:
            self.told.append(call)
            self._ns += MS
            state = RobotState(self._ns, STILL, Twist2D(), 12.6, True, False, False, False, (False,) * 5, (False,) * 5)
            return [state] if call == "poll" else []

        return tell


class Laser:
    """A driver whose laser gives nothing."""

    health = Health("laser", HealthState.OK)

    def __getattr__(self, _: str) -> Callable[..., list[object]]:
        return lambda *_: []


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize(
    ("owner", "name"),
    [(Cadence, "next"), (DeviceThread, "news"), (Requests, "serve"), (BaseLoop, "step"), (RobotDevice, "drive")],
    ids=lambda part: getattr(part, "__name__", part),
)
def test_y3_an_error_or_a_signal_at_any_call_of_the_loop_ends_it_by_closing_its_robot(
    monkeypatch: pytest.MonkeyPatch, owner: type, name: str, error: type[BaseException]
) -> None:
    robot, original, mine = Robot(), vars(owner)[name], threading.get_ident()
    call = original.fget if isinstance(original, property) else original

    def raises(*arguments: object) -> object:
        if threading.get_ident() == mine:
            raise error("oops")
        return call(*arguments)

    def watcher(_: object) -> None:
        if robot.told.count("drive") > 2:
            monkeypatch.setattr(owner, name, property(raises) if isinstance(original, property) else raises)

    base = Base(BaseLoop(CONFIG), robot, Laser(), (Ending(), Ending()), MS, watcher)
    with suppress(SystemExit, KeyboardInterrupt), pytest.raises(ZeroDivisionError, match="oops"):
        base.run()
    assert robot.told[-1] == "close"
    assert robot.told.count("drive") > 2
