# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A device's thread: it starts, polls, starts anew, tells everything, and ends when it is asked to."""

from __future__ import annotations

import os
import threading
import time
import tty

import pytest

from edgefusion.clock import SimClock
from edgefusion.config import BaseConfig
from edgefusion.config.laser import LaserConfig
from edgefusion.config.pioneer import PioneerConfig
from edgefusion.drivers.link import Link, LinkError, LinkLostError
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.errors import RefusedError
from edgefusion.service.device_thread import DeviceThread
from edgefusion.service.ending import EndableLink, Ending
from edgefusion.service.laser_device import LaserDevice
from edgefusion.service.robot_device import RobotDevice
from edgefusion.types import Health, HealthState, Pose2D, Twist2D

MS = 1_000_000
OK = Health("thing", HealthState.OK)
GO = Twist2D(0.3, 0.1)


class Script:
    """A device whose starts and polls do what they are told, in turn, and then nothing more. calls: what was asked."""

    def __init__(self, starts=(), polls=(), close=None) -> None:
        self.starts, self.polls, self.close_error = list(starts), list(polls), close
        self.calls: list[str] = []
        self.health = Health("thing", HealthState.STARTING, "not started")

    def start(self) -> None:
        self.calls.append("start")
        self._do(self.starts)
        self.health = OK

    def poll(self):
        self.calls.append("poll")
        return self._do(self.polls) or []

    def close(self) -> None:
        self.calls.append("close")
        if self.close_error is not None:
            raise self.close_error

    def _do(self, script):
        item = script.pop(0) if script else None
        if isinstance(item, Exception):
            raise item
        if isinstance(item, Health):
            self.health = item
            return []
        return item


class Hands:
    """A thread whose turns are taken by hand, on a clock that stands."""

    def __init__(self, device) -> None:
        self.clock, self.device, self.wakes = SimClock(), device, 0
        self.ending = Ending()
        self.thread = DeviceThread(device, self.ending, self._wake, self.clock, self._pause)

    @property
    def news(self):
        return self.thread.news

    def turns(self, n: int):
        for _ in range(n):
            self.thread.turn()
        return self.news

    def _wake(self) -> None:
        self.wakes += 1

    def _pause(self, seconds: float) -> None:
        self.clock.advance(round(seconds * 1e9))


def test_before_its_first_turn_it_says_what_the_device_says() -> None:
    news = Hands(Script()).news
    assert (news.health.reason, news.newest, news.failures) == ("not started", None, 0)


def test_it_starts_polls_and_keeps_the_newest_with_its_time() -> None:
    hands = Hands(Script(polls=[["a", "b"], [], ["c"]]))
    assert hands.turns(1).health == OK
    hands.clock.advance(30 * MS)
    assert (hands.turns(1).newest, hands.news.received_ns) == ("b", 30 * MS)
    hands.clock.advance(10 * MS)
    assert (hands.turns(1).newest, hands.news.received_ns) == ("b", 30 * MS)
    assert (hands.turns(1).newest, hands.news.received_ns) == ("c", 40 * MS)


def test_what_is_lost_has_no_newest_says_why_and_is_started_anew() -> None:
    hands = Hands(Script(polls=[["old"], LinkLostError("ttyX: vanished")]))
    news = hands.turns(3)
    assert (news.health, news.newest) == (Health("thing", HealthState.FAILED, "ttyX: vanished"), None)
    assert (news.failures, news.failure) == (1, "ttyX: vanished")
    hands.clock.advance(50 * MS)
    assert hands.turns(1).health == OK
    assert (hands.news.newest, hands.news.failures, hands.news.failure) == (None, 1, "ttyX: vanished")


def test_a_device_that_does_not_start_is_tried_ever_more_seldom_until_it_gives_something() -> None:
    device = Script([LinkError("no"), RefusedError("wrong kind"), LinkError("no"), LinkError("no")], [["a"]])
    hands = Hands(device)
    tried_ns = []
    while not hands.news.newest:
        known = len(device.calls)
        hands.turns(1)
        tried_ns += [hands.clock()] * (device.calls[known:] == ["start"])
    assert tried_ns == [0, 50 * MS, 150 * MS, 350 * MS, 600 * MS]
    device.polls = [LinkError("again")]
    hands.turns(1)
    lost_ns = hands.clock()
    while device.calls[-1] != "start":
        hands.turns(1)
    assert hands.clock() - lost_ns == 50 * MS


def test_it_wakes_others_when_the_state_changes_and_at_no_other_time() -> None:
    bad, worse = (Health("thing", HealthState.FAILED, reason) for reason in ("stuck", "stuck and hot"))
    hands = Hands(Script(polls=[["a"], ["b"], bad, worse, OK, ["c"]]))
    wakes = []
    for _ in range(7):
        hands.turns(1)
        wakes.append(hands.wakes)
    assert wakes == [1, 1, 1, 2, 2, 3, 3]


def test_what_a_device_reports_as_failed_counts_as_a_failure_and_is_polled_on() -> None:
    device = Script(polls=[Health("thing", HealthState.FAILED, "dazzled"), OK, ["a"]])
    news = Hands(device).turns(4)
    assert (news.health, news.newest, news.failures, news.failure) == (OK, "a", 1, "dazzled")
    assert device.calls.count("start") == 1


def test_a_port_that_another_instance_holds_is_told_apart(tmp_path) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    first, second = (Link(os.ttyname(slave), 9600, holder, lock_folder=tmp_path) for holder in ("first", "second"))
    first.open()
    hands = Hands(LaserDevice(Lms2xx(second, LaserConfig()), lambda: False))
    hands.turns(1)
    assert "held by first (pid " in str(hands.thread.busy)
    assert hands.news.health.reason == str(hands.thread.busy)
    first.close()
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(
    "device",
    [Script(polls=[ZeroDivisionError("oops")]), Script([ZeroDivisionError("oops")])],
    ids=["poll", "start"],
)
def test_an_error_that_no_driver_should_raise_closes_the_device_for_good_and_says_so(device, caplog) -> None:
    hands = Hands(device)
    hands.thread.run()
    assert device.calls[-1] == "close"
    assert hands.news.health == Health("thing", HealthState.FAILED, "closed after ZeroDivisionError: oops")
    assert hands.news.failures == 1
    assert "ZeroDivisionError: oops" in caplog.text


def test_an_error_at_closing_does_not_go_unseen() -> None:
    hands = Hands(Script(polls=[ZeroDivisionError("oops")], close=OSError("stuck")))
    hands.thread.run()
    assert hands.news.health.reason == "closed after OSError: stuck"


def test_asked_to_end_it_closes_the_device() -> None:
    device = Script()
    hands = Hands(device)
    hands.thread.begin()
    hands.thread.end()
    assert hands.thread.join(5)
    assert device.calls[-1] == "close"
    assert not hands.thread.is_alive


def test_a_thread_that_was_never_begun_has_ended() -> None:
    assert Hands(Script()).thread.join(0)


@pytest.mark.parametrize("kind", ["robot", "laser"])
def test_a_thread_in_the_middle_of_a_search_of_seconds_ends_at_once(kind: str, tmp_path) -> None:
    master, slave = os.openpty()  # nobody answers
    tty.setraw(slave)
    link = EndableLink(os.ttyname(slave), 9600, lock_folder=tmp_path)
    robot = RobotDevice(Pioneer(link, PioneerConfig(), BaseConfig()))
    device = robot if kind == "robot" else LaserDevice(Lms2xx(link, LaserConfig()), lambda: False)
    thread = DeviceThread(device, link.ending, lambda: None)
    thread.begin()
    assert os.read(master, 100)  # it searches
    began_s = time.monotonic()
    thread.end()
    assert thread.join(5)
    # A search takes 4 s; the laser is asked once more to stop, and that has a deadline of its own.
    assert time.monotonic() - began_s < 3
    assert not link.is_open
    os.close(master)
    os.close(slave)


class Driver:
    """A robot's driver that notes what it is told; reports: what the polls give, with the health from then on."""

    def __init__(self) -> None:
        self.health = Health("robot", HealthState.OK)
        self.told: list[object] = []
        self.reports: list[Health] = []

    def start(self) -> None:
        self.told.append("start")

    def poll(self) -> list[RobotState]:
        if not self.reports:
            return []
        self.health = self.reports.pop(0)
        rear = {9: 0.5, 12: 1.0, 3: 0.7}
        return [RobotState(0, Pose2D(), Twist2D(), 12.0, True, False, False, False, (), (), rear)]

    def drive(self, twist: Twist2D, given_ns: int | None = None) -> None:
        self.told.append(twist)

    def stop(self) -> None:
        self.told.append("stop")

    def enable_motors(self) -> None:
        self.told.append("motors")

    def close(self) -> None:
        self.told.append("close")


def started(clock: SimClock | None = None) -> tuple[Driver, RobotDevice, int]:
    driver = Driver()
    device = RobotDevice(driver, clock or SimClock())
    device.start()
    driver.reports = [driver.health]
    (report,) = device.poll()
    driver.told.clear()
    return driver, device, report.session


def test_the_newest_command_is_handed_to_the_driver_once() -> None:
    driver, device, session = started()
    device.drive(0, Twist2D(0.1, 0), session)
    device.drive(0, GO, session)
    for _ in range(3):
        device.poll()
    assert driver.told == [GO]


def test_a_command_of_before_a_start_moves_nothing_after_it() -> None:
    driver, device, session = started()
    device.drive(0, GO, session)
    device.start()
    device.drive(0, GO, session)
    device.poll()
    assert driver.told == ["start"]
    device.drive(0, GO, session + 1)
    device.poll()
    assert driver.told == ["start", GO]


def test_a_command_that_has_grown_old_before_it_could_be_handed_over_is_not() -> None:
    clock = SimClock()
    driver, device, session = started(clock)
    device.drive(0, GO, session)
    clock.advance(301 * MS)  # as in a process that is halted for a while
    device.poll()
    assert driver.told == []
    device.drive(1 * MS, GO, session)
    device.poll()
    assert driver.told == [GO]


def test_a_report_by_which_it_must_not_be_driven_is_answered_by_a_stop_whatever_is_commanded() -> None:
    driver, device, session = started()
    well, bumped = driver.health, Health("robot", HealthState.FAILED, "bumped: front 1")
    driver.reports = [bumped, bumped]
    device.drive(0, GO, session)
    device.poll()
    device.drive(0, GO, session)
    device.poll()
    device.drive(0, GO, session)
    device.poll()  # without a report: nothing new
    assert driver.told == ["stop", "stop"]
    driver.reports = [well]
    device.poll()
    device.drive(0, GO, session)
    device.poll()
    assert driver.told == ["stop", "stop", GO]


def test_motors_are_enabled_once_when_somebody_asks_for_it_also_while_it_must_not_be_driven() -> None:
    driver, device, _ = started()
    driver.reports = [Health("robot", HealthState.FAILED, "the motors are off")]
    device.enable_motors()
    device.poll()
    device.poll()
    assert driver.told == ["stop", "motors"]


def test_what_the_rear_sonar_hears_is_reported_as_points_behind_the_robot() -> None:
    driver, device, _ = started()
    driver.reports = [driver.health]
    (report,) = device.poll()
    assert report.rear_points_m.shape == (2, 2)
    assert (report.rear_points_m[:, 0] < -0.3).all()


def test_news_may_be_read_while_the_thread_works() -> None:
    hands = Hands(Script(polls=[[number] for number in range(2000)]))
    hands.thread.begin()
    seen, end = [], threading.Event()
    while not end.is_set():
        seen.append(hands.news.newest)
        if seen[-1] == 1999:
            end.set()
    hands.thread.end()
    assert hands.thread.join(5)
    known = [number for number in seen if number is not None]
    assert known == sorted(known)
