# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What becomes of a driving robot when something is wrong with its laser: the figures L1 to L6, in virtual time."""

from __future__ import annotations

import math
import os

import pytest
from virtual_base import S

from edgefusion.navigation.mission_step import MissionState

SEEDS = range(int(os.environ.get("EDGEFUSION_FAULT_SEEDS", "3")))
"""Three each time; twenty take two minutes."""
BOTH_SPEEDS = pytest.mark.parametrize(("baudrate", "limit_s"), [(500000, 0.2), (38400, 0.53)])
CYCLES_S = 0.1
"""Beside the threads of the real base, which read at the same time, the turns of the virtual one cost up to so much."""


@pytest.mark.parametrize("seed", SEEDS)
@BOTH_SPEEDS
def test_l1_a_laser_that_falls_silent_stops_the_robot_and_lets_it_go_on_when_it_speaks_again(
    base, seed, baudrate, limit_s
) -> None:
    robot = base(seed, baudrate).driving()
    assert robot.stopped_after_s(robot.inject("laser=off")) <= limit_s + CYCLES_S
    assert robot.moved_m(1.0) == 0.0
    robot.mend("laser")
    robot.run(8.0, robot.well)
    robot.run(3.0)
    assert robot.world.body.twist.v_mps > 0 or robot.outputs[-1].mission.state is MissionState.ARRIVED


@pytest.mark.parametrize("seed", SEEDS)
def test_l2_a_laser_that_is_unplugged_is_lost_at_once_and_back_within_a_second(base, seed) -> None:
    robot = base(seed).driving()
    robot.lines["laser"].plugged = False
    assert robot.stopped_after_s(robot.clock()) <= 0.1 + CYCLES_S
    assert robot.moved_m(0.5) == 0.0
    robot.lines["laser"].plugged = True
    plugged_ns, seen = robot.clock(), len(robot.laser_turn.losses)
    robot.run(8.0, robot.well)
    assert robot.clock() - plugged_ns <= 1.0 * S and len(robot.laser_turn.losses) == seen
    back = robot.run(0.06)
    assert back[0].command.v_mps == 0.0 and "5 fresh in a row" in back[0].decision.reason  # five good scans first


@pytest.mark.parametrize("seed", SEEDS)
def test_l3_a_laser_that_repeats_itself_is_found_out_within_five_scans_while_it_drives(base, seed) -> None:
    robot = base(seed).driving()
    scans_s = 5 * 0.02667
    assert robot.stopped_after_s(robot.inject("laser=stuck")) <= scans_s + 0.05 + CYCLES_S
    assert "repeats itself" in robot.laser_turn.news.health.reason


def test_l3_in_a_second_while_it_stands(base) -> None:
    robot = base()
    robot.run(4.0, robot.well)
    since_ns = robot.inject("laser=stuck")
    robot.run(3.0, lambda: not robot.well())
    assert 0.9 <= (robot.clock() - since_ns) / S <= 1.2


@pytest.mark.parametrize("seed", SEEDS)
def test_l4_a_line_of_noise_is_as_bad_as_none(base, seed) -> None:
    robot = base(seed).driving()
    assert robot.stopped_after_s(robot.inject("laser=garbage:0.01")) <= 0.2 + CYCLES_S
    assert robot.moved_m(1.0) == 0.0


def test_l4_a_line_with_little_noise_is_driven_by(base) -> None:
    robot = base().driving()
    robot.inject("laser=garbage:0.0001")
    outputs = robot.run(2.0)
    assert min(each.command.v_mps for each in outputs) > 0.2


@pytest.mark.parametrize("seed", SEEDS)
def test_l5_a_covered_laser_stops_it_within_two_scans_and_says_why(base, seed) -> None:
    robot = base(seed).driving()
    robot.scanner.covered = True
    # Two scans that are complete, and the way of the second over the line.
    assert robot.stopped_after_s(robot.clock()) <= 3 * 0.02667 + 0.0146 + 0.05 + CYCLES_S
    assert "covered or dazzled: 361 of 361 beams" in robot.laser_turn.news.health.reason


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("late_s", [0.3, 0.0])
def test_l6_it_never_drives_by_a_scan_that_is_too_old(base, seed, late_s) -> None:
    robot = base(seed).driving()
    robot.scan_delay_s = late_s
    if not late_s:
        robot.inject("laser=intermittent:0.5")
    outputs = robot.run(3.0)
    moving = [each for each in outputs if each.command.v_mps or each.command.w_radps]
    assert all(_age_s(robot, each) <= robot.age_limit_s for each in moving)
    if late_s:
        assert all(each.command.v_mps == 0.0 for each in outputs[8:])  # 0.3 s is more than 0.15 s


def _age_s(robot, outputs) -> float:
    scans = [each.scan for each in robot.outputs if each.scan is not None and each.stamp_ns <= outputs.stamp_ns]
    return (outputs.stamp_ns - scans[-1].stamp_ns) / S if scans else math.inf
