# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who drives: a stop beats everything, a cmd_vel pauses the mission, and neither is left but by resume."""

from __future__ import annotations

from typing import List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.bus.arbiter import Arbiter, Driver, Order
from edgefusion.errors import RefusedError
from edgefusion.types import Twist2D

MS = 1_000_000
DEADMAN_NS = 200 * MS
AHEAD = Twist2D(0.3, 0.1)
MISSION = Order(Driver.MISSION, None)
STILL = Order(Driver.OPERATOR, Twist2D())


def arbiter() -> Arbiter:
    return Arbiter(DEADMAN_NS)


def test_the_mission_drives_until_somebody_else_wants_to() -> None:
    assert arbiter().decide(0) == MISSION


def test_a_cmd_vel_pauses_the_mission_until_resume() -> None:
    it = arbiter()
    it.cmd_vel(0, AHEAD)
    assert it.decide(0) == Order(Driver.OPERATOR, AHEAD)
    assert it.decide(10**12).driver is Driver.OPERATOR
    assert it.resume(10**12)
    assert it.decide(10**12) == MISSION


def test_a_cmd_vel_is_followed_for_as_long_as_the_deadman_allows() -> None:
    it = arbiter()
    it.cmd_vel(1000, AHEAD)
    assert it.decide(1000 + DEADMAN_NS) == Order(Driver.OPERATOR, AHEAD)
    assert it.decide(1001 + DEADMAN_NS) == STILL


def test_a_stop_beats_everything_and_keeps_its_first_reason() -> None:
    it = arbiter()
    it.cmd_vel(0, AHEAD)
    it.stop("asked to")
    it.stop("again")
    it.cmd_vel(1, AHEAD)
    assert it.decide(1) == Order(Driver.NOBODY, Twist2D(), "asked to")


def test_what_was_commanded_before_a_resume_is_worth_nothing_after_it() -> None:
    it = arbiter()
    it.cmd_vel(0, AHEAD)
    it.stop("asked to")
    it.cmd_vel(1, AHEAD)
    it.resume(2)
    assert it.decide(2) == MISSION
    it.cmd_vel(3, AHEAD)
    assert it.decide(3) == Order(Driver.OPERATOR, AHEAD)


def test_resume_says_whether_there_was_anything_to_leave() -> None:
    it = arbiter()
    assert not it.resume(0)
    it.stop("asked to")
    assert it.resume(0)
    assert not it.resume(0)


def test_a_stop_without_a_reason_is_refused() -> None:
    with pytest.raises(RefusedError, match="reason"):
        arbiter().stop("")


def test_without_the_operator_who_is_required_nobody_drives() -> None:
    it = Arbiter(DEADMAN_NS, operator_timeout_ns=500 * MS)
    assert it.decide(0).driver is Driver.NOBODY
    with pytest.raises(RefusedError, match="no operator"):
        it.resume(0)
    it.heartbeat(0)
    assert it.decide(1).driver is Driver.NOBODY  # until somebody says that it may go on
    it.resume(1)
    assert it.decide(500 * MS) == MISSION


def test_a_heartbeat_that_fails_stops_the_robot_until_resume() -> None:
    it = Arbiter(DEADMAN_NS, operator_timeout_ns=500 * MS)
    it.heartbeat(0)
    it.resume(0)
    it.cmd_vel(450 * MS, AHEAD)
    order = it.decide(500 * MS + 1)
    assert (order.driver, order.reason) == (Driver.NOBODY, "no heartbeat of an operator for 0.5 s")
    it.heartbeat(600 * MS)
    assert it.decide(600 * MS).driver is Driver.NOBODY


Event = Tuple[str, int]


@given(st.lists(st.tuples(st.sampled_from(("cmd_vel", "stop", "resume", "decide")), st.integers(0, 300 * MS))))
def test_on_any_day_nothing_moves_after_a_stop_or_an_old_cmd_vel(events: List[Event]) -> None:
    it, now_ns, stopped, paused, told_ns = arbiter(), 0, False, False, -(10**12)
    for kind, gap_ns in events:
        now_ns += gap_ns
        if kind == "cmd_vel":
            it.cmd_vel(now_ns, AHEAD)
            if not stopped:
                paused, told_ns = True, now_ns
        elif kind == "stop":
            it.stop("asked to")
            stopped, told_ns = True, -(10**12)
        elif kind == "resume":
            assert it.resume(now_ns) == (stopped or paused)
            stopped, paused, told_ns = False, False, -(10**12)
        order = it.decide(now_ns)
        assert order.driver is (Driver.NOBODY if stopped else Driver.OPERATOR if paused else Driver.MISSION)
        if order.driver is not Driver.MISSION:
            fresh = not stopped and now_ns - told_ns <= DEADMAN_NS
            assert order.twist == (AHEAD if fresh else Twist2D())
