# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the base's loop is made of: its pace, its wake-up, what others want from it, its pose between reports."""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.clock import SimClock
from edgefusion.errors import RefusedError
from edgefusion.service.cadence import Cadence, Lateness
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.failure_watch import FailureWatch
from edgefusion.service.pose_track import PoseTrack
from edgefusion.service.requests import Requests
from edgefusion.service.signals import ended_by_signals
from edgefusion.types import Health, HealthState, Pose2D, Twist2D
from edgefusion.waiting import Wake

MS = 1_000_000
PERIOD_NS = 50 * MS


class Waits:
    """Waits on a clock that stands, by so much longer or shorter as it is told, in turn."""

    def __init__(self, *off_ms: float) -> None:
        self.clock, self._off_ms = SimClock(7 * MS), list(off_ms)

    def __call__(self, seconds: float) -> None:
        off_ms = self._off_ms.pop(0) if self._off_ms else 0
        self.clock.advance(round(seconds * 1e9 + off_ms * MS))


def cycles_ms(waits: Waits, work_ms: list[float]) -> list[float]:
    """When cycles begin, counted from the first, that work so long each."""
    cadence = Cadence(PERIOD_NS, waits.clock, waits)
    times_ns = []
    for ms in work_ms:
        times_ns.append(cadence.next())
        waits.clock.advance(round(ms * MS))
    return [(each - times_ns[0]) / MS for each in times_ns]


def test_the_pace_is_steady_however_long_the_work_takes() -> None:
    assert cycles_ms(Waits(), [10, 49, 0, 50, 3]) == [0, 50, 100, 150, 200]


def test_waits_that_last_too_long_do_not_add_up() -> None:
    assert cycles_ms(Waits(3, 2, 4), [10, 10, 10, 10]) == [0, 53, 102, 154]


def test_a_cycle_that_is_missed_is_not_made_up_for() -> None:
    assert cycles_ms(Waits(), [10, 120, 10, 10]) == [0, 50, 170, 200]


def test_a_cycle_that_was_woken_early_changes_nothing_for_the_next() -> None:
    assert cycles_ms(Waits(-20, 0), [10, 5, 5]) == [0, 30, 50]


@given(st.lists(st.floats(0, 200), min_size=2, max_size=30))
def test_every_cycle_begins_when_it_is_due_or_at_once_where_that_is_past(work_ms) -> None:
    times_ms = cycles_ms(Waits(), work_ms)
    for before, after, ms in zip(times_ms, times_ms[1:], work_ms):
        next_due = (before // 50 + 1) * 50
        assert after == pytest.approx(max(next_due, before + ms), abs=1e-5)


def test_lateness_is_counted_from_when_cycles_were_due() -> None:
    waits = Waits(*[1.0] * 98, 30.0)
    cadence = Cadence(PERIOD_NS, waits.clock, waits)
    assert cadence.lateness == Lateness(0, 0.0, 0.0, 0.0)
    for _ in range(100):
        cadence.next()
    lateness = cadence.lateness
    assert (lateness.cycles, lateness.p50_ms, lateness.max_ms) == (100, pytest.approx(1), pytest.approx(30))
    assert 1 <= lateness.p99_ms <= 30


def test_a_pace_of_no_time_is_refused() -> None:
    with pytest.raises(RefusedError, match="period_ns: expected at least 1, got 0"):
        Cadence(0, SimClock(), lambda seconds: None)


def test_a_wait_ends_early_when_it_is_called_before_or_meanwhile() -> None:
    wake = Wake()
    for _ in range(100_000):  # more than a pipe holds
        wake()
    while wake.wait(0):
        pass
    assert not wake.wait(0.01)
    threading.Timer(0.02, wake).start()
    began_s = time.monotonic()
    assert wake.wait(10)
    assert time.monotonic() - began_s < 9


def asked(requests: Requests, call):
    """What another thread gets that asks, while this one serves."""
    results = []

    def ask() -> None:
        try:
            results.append(requests.ask(call, 5))
        except Exception as error:
            results.append(error)

    thread = threading.Thread(target=ask)
    thread.start()
    while thread.is_alive():
        requests.serve()
        time.sleep(0.001)
    return results[0]


def test_who_asks_gets_the_answer_or_the_refusal_of_a_call_made_by_who_serves() -> None:
    wakes = []
    requests = Requests(lambda: wakes.append(1))
    assert asked(requests, threading.current_thread) is threading.current_thread()
    refusal = RefusedError("goal: refused")

    def refuse() -> None:
        raise refusal

    assert asked(requests, refuse) is refusal
    assert len(wakes) == 2


def test_who_is_not_served_in_time_is_told_so_and_the_call_is_never_made() -> None:
    requests, calls = Requests(lambda: None), []
    with pytest.raises(TimeoutError, match=r"expected an answer within 0\.01 s, got none: the loop is late"):
        requests.ask(lambda: calls.append(1), 0.01)
    requests.serve()
    assert calls == []


def test_what_is_to_be_done_also_when_it_is_late_is_done() -> None:
    requests, calls = Requests(lambda: None), []
    with pytest.raises(TimeoutError, match="the loop is late"):
        requests.ask(lambda: calls.append(1), 0.01, late_too=True)
    requests.serve()
    assert calls == [1]


def track() -> PoseTrack:
    poses = PoseTrack(250 * MS)
    poses.report(0, Pose2D(), Twist2D(0.5, 0.0))
    poses.report(100 * MS, Pose2D(0.05, 0.0, 0.0), Twist2D(0.4, 1.0))
    return poses


def test_between_reports_poses_are_interpolated_and_after_the_newest_carried_on_along_its_arc() -> None:
    poses = track()
    assert poses.at(50 * MS) == Pose2D(0.025, 0.0, 0.0)
    assert poses.at(200 * MS) == Pose2D(0.05, 0.0, 0.0).compose(Twist2D(0.4, 1.0).motion(0.1))


def test_nothing_is_carried_on_for_longer_than_it_may_be() -> None:
    poses = track()
    with pytest.raises(RefusedError, match="stamp_ns: the newest report is of 100000000, got 351000000"):
        poses.at(351 * MS)
    assert poses.now(900 * MS) == poses.at(350 * MS)
    assert PoseTrack(MS).now(0) is None


def test_a_report_that_is_known_already_changes_nothing() -> None:
    poses = track()
    poses.report(100 * MS, Pose2D(9.0, 9.0, 0.0), Twist2D())
    assert poses.at(100 * MS) == Pose2D(0.05, 0.0, 0.0)


def test_a_failure_is_seen_once_when_it_is_over_and_always_while_it_lasts() -> None:
    watch, ok, bad = FailureWatch(), Health("robot", HealthState.OK), Health("robot", HealthState.FAILED, "gone")
    assert watch.look(DeviceNews(ok)) == (ok,)
    assert watch.look(DeviceNews(ok, failures=2, failure="gone")) == (ok, bad)
    assert watch.look(DeviceNews(ok, failures=2, failure="gone")) == (ok,)
    assert watch.look(DeviceNews(bad, failures=3, failure="gone")) == (bad,)
    assert watch.look(DeviceNews(bad, failures=3, failure="gone")) == (bad,)
    assert watch.look(DeviceNews(ok, failures=3, failure="gone")) == (ok,)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_what_runs_once_and_lets_it_clean_up(number: int) -> None:
    before, cleaned = signal.getsignal(number), []
    with pytest.raises(SystemExit), ended_by_signals():
        try:
            os.kill(os.getpid(), number)
            time.sleep(10)
        finally:
            os.kill(os.getpid(), number)
            time.sleep(0.01)
            cleaned.append(math.pi)
    assert cleaned == [math.pi]
    assert signal.getsignal(number) is before


def test_a_signal_that_comes_where_python_drops_exceptions_ends_the_program_all_the_same() -> None:
    class Told:
        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(0.01)

    before, hook = signal.getsignal(signal.SIGTERM), sys.unraisablehook
    with pytest.raises(SystemExit), ended_by_signals():
        Told()
        time.sleep(10)
        pytest.fail("it went on")
    assert (signal.getsignal(signal.SIGTERM), sys.unraisablehook) == (before, hook)


def test_a_signal_that_was_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ended_by_signals():
            os.kill(os.getpid(), signal.SIGHUP)
            time.sleep(0.01)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
