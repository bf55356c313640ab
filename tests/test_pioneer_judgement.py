# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a Pioneer may be driven: what it reports, what it does against what it was told, and its battery."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Optional

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.pioneer_judgement import Judgement
from edgefusion.drivers.pioneer_limits import limits_of
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.errors import RefusedError
from edgefusion.types import STILL, Health, HealthState, Twist2D

LIMITS = limits_of(BaseConfig(), None)
CYCLE_NS = 100_000_000
NONE = (False,) * 5
REST = Twist2D()
WELL = RobotState(0, STILL, Twist2D(), 12.6, True, False, False, False, NONE, NONE)
VELOCITIES = st.tuples(st.floats(-0.5, 0.5), st.floats(-1.0, 1.0))


def judge(states: list[RobotState], commanded: Optional[Twist2D] = REST) -> list[Health]:
    """Of states that come one cycle after the other."""
    judgement, pose, healths = Judgement(PioneerConfig(), LIMITS), STILL, []
    for i, state in enumerate(states):
        pose = pose.compose(state.twist.motion(CYCLE_NS / 1e9))
        healths.append(judgement.judge(replace(state, stamp_ns=i * CYCLE_NS, odometry=pose), commanded))
    return healths


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ({"motors_enabled": False}, "the motors are off"),
        ({"e_stop_pressed": True}, "the emergency stop is pressed"),
        ({"stalled_left": True}, "left wheel stalled"),
        ({"stalled_left": True, "stalled_right": True}, "both wheels stalled"),
        ({"front_bumpers": (False, True, False, False, False)}, "bumped: front 2"),
        ({"rear_bumpers": (True, False, False, False, True)}, "bumped: rear 1, rear 5"),
    ],
)
def test_what_it_reports_fails_it_at_once_and_only_for_as_long_as_it_lasts(fault: dict, reason: str) -> None:
    for before in ([], [WELL] * 5):  # at boot, and at work
        healths = judge([*before, replace(WELL, **fault), WELL])
        assert (healths[-2].state, healths[-2].reason) == (HealthState.FAILED, reason)
        assert healths[-1].state is HealthState.OK


@pytest.mark.parametrize(
    ("commanded", "measured"),
    [((0.3, 0.0), (0.0, 0.0)), ((0.0, 0.8), (0.0, 0.0)), ((0.3, 0.0), (-0.3, 0.0)), ((0.0, 0.0), (0.4, 0.0))],
)
def test_wheels_that_do_otherwise_than_told_for_a_second_fail_it(commanded: tuple, measured: tuple) -> None:
    moving = replace(WELL, twist=Twist2D(*measured))
    healths = judge([WELL] + [moving] * 30, Twist2D(*commanded))
    failed = [i for i, health in enumerate(healths) if health.state is HealthState.FAILED]
    assert healths[failed[0]].reason == "the wheels do not do what they were told"
    assert 700_000_000 <= failed[0] * CYCLE_NS <= 1_000_000_000


def test_reports_that_are_stuck_fail_it_though_they_say_the_speed_that_was_told() -> None:
    judgement = Judgement(PioneerConfig(), LIMITS)
    stuck = replace(WELL, twist=Twist2D(0.3))
    healths = [judgement.judge(replace(stuck, stamp_ns=i * CYCLE_NS), Twist2D(0.3)) for i in range(20)]
    assert healths[-1].reason == "the wheels do not do what they were told"


@given(steps=st.lists(VELOCITIES, min_size=1, max_size=6), acceleration=st.floats(0.2, 2.0))
def test_a_drive_that_follows_late_and_by_its_ramps_obeys(steps: list, acceleration: float) -> None:
    base = BaseConfig(acceleration_mps2=acceleration)
    judgement, v, w = Judgement(PioneerConfig(), limits_of(base, None)), 0.0, 0.0
    commanded, pose = Twist2D(), STILL
    for cycle in range(len(steps) * 15):
        late = commanded
        commanded = Twist2D(*steps[cycle // 15])
        v += max(-acceleration / 10, min(acceleration / 10, late.v_mps - v))
        change = base.yaw_acceleration_radps2 / 10
        w += max(-change, min(change, late.w_radps - w))
        pose = pose.compose(Twist2D(v, w).motion(CYCLE_NS / 1e9))
        state = replace(WELL, stamp_ns=cycle * CYCLE_NS, twist=Twist2D(v, w), odometry=pose)
        assert judgement.judge(state, commanded).state is HealthState.OK


def test_a_robot_that_turns_by_itself_cannot_disobey() -> None:
    turning = replace(WELL, twist=Twist2D(0.0, math.radians(60)))
    assert all(health.state is HealthState.OK for health in judge([turning] * 30, None))


def test_a_low_battery_is_said_and_an_empty_one_fails_it() -> None:
    low, empty = replace(WELL, battery_v=11.4), replace(WELL, battery_v=10.9)
    healths = judge([WELL] + [low] * 60 + [empty] * 60)
    states = [health.state for health in healths]
    assert states[40] is HealthState.OK
    assert (healths[55].state, healths[55].reason) == (HealthState.DEGRADED, "the battery is low: 11.4 V")
    assert states[100] is HealthState.DEGRADED
    assert (healths[-1].state, healths[-1].reason) == (HealthState.FAILED, "the battery is empty: 10.9 V")


def test_a_battery_that_dips_under_load_is_not_low() -> None:
    dips = [WELL] + [replace(WELL, battery_v=10.5)] * 40 + [WELL]
    assert {health.state for health in judge(dips * 3)} == {HealthState.OK}


def test_a_battery_that_is_empty_at_the_start_fails_it_at_once() -> None:
    assert judge([replace(WELL, battery_v=10.0)])[0].reason == "the battery is empty: 10.0 V"


def test_low_must_be_above_empty() -> None:
    with pytest.raises(RefusedError, match=r"low_battery_v: expected more than empty_battery_v, 12, got 11.5"):
        PioneerConfig(empty_battery_v=12.0)
