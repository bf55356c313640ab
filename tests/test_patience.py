# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When it is tried otherwise, and when it is given up: by stamps alone."""

from __future__ import annotations

import math

import pytest

from edgefusion.navigation.patience import Patience, Shut, Stall
from edgefusion.navigation.progress import Reason
from edgefusion.types import Pose2D

S = 1_000_000_000
HERE = Pose2D()


def turned(degrees):
    return Pose2D(0.0, 0.0, math.radians(degrees))


def test_a_robot_that_stays_is_stalled_after_a_while():
    stall = Stall()
    answers = [stall.lasts(5 * S + tick * S // 10, HERE) for tick in range(10)]
    assert answers == [False] * 8 + [True] * 2  # from 0.8 s on


def stays(stall, pose, from_s, until_s):
    """The last answer of those asked ten times a second."""
    return [stall.lasts(round(tick * S / 10), pose) for tick in range(round(10 * from_s), round(10 * until_s) + 1)][-1]


@pytest.mark.parametrize(
    ("moved", "stalled"),
    [(Pose2D(0.02, 0.02, 0.0), True), (Pose2D(0.03, 0.01, 0.0), False), (turned(5.9), True), (turned(-6.1), False)],
)
def test_to_move_or_to_turn_is_not_to_be_stalled(moved, stalled):
    stall = Stall()
    stays(stall, HERE, 0, 0.4)
    assert stays(stall, moved, 0.5, 1.0) is stalled
    assert stays(stall, moved, 1.1, 2.0)


def test_only_steps_in_which_it_is_asked_count():
    stall = Stall()
    stays(stall, HERE, 0, 0.4)
    assert not stays(stall, HERE, 60, 60.1)
    assert not stays(stall, HERE, 90, 90)
    assert stays(stall, HERE, 90, 90.1)


@pytest.mark.parametrize(("rate", "stalled"), [(2.0, False), (0.5, True)])
def test_who_is_nearly_there_may_turn_slowly_but_has_to_turn(rate, stalled):
    """From 4 degrees off, proportionally to what is left."""
    stall, off = Stall(), 4.0
    answers = []
    for tick in range(25):
        answers.append(stall.lasts(tick * S // 20, turned(off), math.radians(off)))
        off -= rate * off / 20
    assert any(answers) is stalled


def test_to_go_to_and_fro_on_the_spot_is_to_be_stalled():
    stall = Stall()
    answers = [stall.lasts(tick * S // 10, turned(4 * (-1) ** tick if tick else 0)) for tick in range(10)]
    assert answers[-1]


def test_a_turn_across_the_half_turn_is_a_small_one():
    stall = Stall()
    stays(stall, turned(179), 0, 0.3)
    assert stays(stall, turned(-179), 0.4, 0.8)


def test_a_way_that_is_shut_for_long_enough_is_given_up_for_the_newest_reason():
    shut = Shut()
    answers = [shut.lasts(tick * S, Reason.ENCLOSED) for tick in range(4)]
    assert answers == [None] * 4
    assert shut.lasts(3 * S + 1, Reason.OCCUPIED) is Reason.OCCUPIED


def test_a_passer_by_shuts_no_way():
    shut = Shut()
    for tick in range(20):
        assert shut.lasts(tick * S, None if tick % 3 == 2 else Reason.ENCLOSED) is None


def over_at(left_by_s, patience_s=5.0, until_s=300, speed_mps=0.0):
    """When it is over [s], asked every second of a robot that drives; None for never."""
    patience = Patience(patience_s)
    seconds = (
        second
        for second in range(until_s)
        if patience.is_over(second * S, left_by_s(second), Pose2D(speed_mps * second, 0.0, 0.0))
    )
    return next(seconds, None)


@pytest.mark.parametrize(
    ("left_by_s", "over_s"),
    [
        (lambda second: 10.0, 6),
        (lambda second: math.inf, 6),
        (lambda second: 50.0 - 0.15 * second, None),
        (lambda second: 20.0 - 0.015 * second, 6),  # slower than 0.1 m in 5 s
        (lambda second: 20.0 - 0.03 * second, None),  # in steps too small to count one by one
        (lambda second: 10.0 - 0.25 * min(second, 8), 14),
        (lambda second: 10.0 + 0.2 * second, 6),  # creeping away is no detour
        (lambda second: math.inf if second < 4 else 10.0, 10),
    ],
)
def test_patience_lasts_as_long_as_it_gets_nearer(left_by_s, over_s):
    assert over_at(left_by_s) == over_s


@pytest.mark.parametrize(
    ("left_by_s", "over_s"),
    [
        (lambda second: 10.0 if second < 4 else 14.0 - 0.001 * second, 10),
        (lambda second: 10.0 if second < 4 else math.inf if second < 5 else 14.0, 11),  # no way known in between
        (lambda second: 10.0 if second < 4 else 6.0, 10),  # a shortcut
        (lambda second: 10.0 + 2.0 * (second % 2), 2 * Patience.MOST_DETOURS + 1),  # to and fro is not allowed for ever
    ],
)
def test_a_detour_begins_it_anew_where_the_robot_gets_about(left_by_s, over_s):
    assert over_at(left_by_s, speed_mps=1.0) == over_s


@pytest.mark.parametrize(
    "ways_m", [(10.0, 12.0), (5.0, 6.0, 5.85), (5.0, 9.0, 8.8, 8.6), (5.0, math.inf, 7.0, 6.8)], ids=str
)
def test_detours_that_come_and_go_while_the_robot_stays_last_no_longer_than_once_more(ways_m) -> None:
    assert over_at(lambda second: ways_m[second % len(ways_m)]) <= 11


def test_to_and_fro_within_half_a_metre_is_to_stay() -> None:
    patience = Patience(5.0)
    ways = (5.0, 6.0, 5.85)
    over = [
        second
        for second in range(60)
        if patience.is_over(second * S, ways[second % 3], Pose2D(0.2 * (second % 2), 0.0, 0.0))
    ]
    assert over[0] <= 11


def test_it_lasts_as_long_as_it_is_told_to():
    assert over_at(lambda second: 1.0, patience_s=20.0) == 21


def test_what_is_paused_does_not_count():
    patience = Patience(5.0)
    patience.pause(100 * S)  # before it has begun there is nothing to pause
    assert not patience.is_over(0, 3.0, HERE)
    patience.pause(10 * S)
    assert not patience.is_over(15 * S, 3.0, HERE)
    assert patience.is_over(15 * S + 1, 3.0, HERE)
