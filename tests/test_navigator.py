# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The navigator's door: how goals begin, end and follow one another, and what a step answers."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.maze_shapes import box, wall

from edgefusion.config import NavigationConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.progress import Reason, State
from edgefusion.types import FARTHEST_M, Goal, Pose2D, Scan, Twist2D
from navigator_drives import BASE, HERE, KHATIB, NAVIGATION, OPEN, Drive, S, goal_at, is_at, off

CELL = np.vstack([box((2.5, 0.0), 1.2, 1.2), box((2.5, 0.0), 1.6, 1.6)])
PILLAR = box((2.0, 0.0), 0.4, 0.4)
BESIDE = box((1.2, 0.35), 0.4, 0.4)
"""Beside the way to (2, 0), so that it has to be gone around."""

ACROSS = wall((1.0, -1.0), (1.0, 1.0))
"""A wall across the way to (2, 0)."""


def free_scan(stamp_ns):
    return Scan(stamp_ns, np.full(361, np.inf), -math.pi / 2, math.radians(0.5), range_max_m=8.0)


@pytest.mark.parametrize(
    "goal",
    [goal_at(2.0, 1.0, 2.0), goal_at(-1.0, 0.5), goal_at(0.0, -1.0, -3.1), goal_at(1.0, 0.0, math.pi)],
)
def test_a_goal_on_open_ground_is_reached_within_its_tolerances(goal):
    drive = Drive(OPEN).until_end(goal, 20)
    assert drive.last.state is State.ARRIVED
    assert drive.last.goal_id == "goal"
    assert drive.last.reason is None
    assert is_at(drive.sim.pose, goal)
    assert off(drive.sim.pose, goal)[1] <= goal.heading_tolerance / 2  # where nothing is in the way of the turn
    assert abs(drive.sim.twist.v_mps) < 0.02


@pytest.mark.parametrize(("x_m", "y_m", "theta"), [(0.1, 0.0, 0.3), (-0.12, 0.1, 2.0)])
def test_tighter_tolerances_are_kept_too(x_m, y_m, theta):
    goal = goal_at(x_m, y_m, theta, position_tolerance_m=0.02, heading_tolerance=math.radians(2))
    drive = Drive(OPEN).until_end(goal, 20)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.pose, goal)
    assert "manoeuvres" not in [step.progress.note for step in drive.steps]  # a slow turn is no standstill


def test_with_a_tolerance_of_pi_no_heading_is_turned_to():
    drive = Drive(OPEN).until_end(goal_at(1.0, 0.0, math.pi, heading_tolerance=math.pi), 10)
    assert drive.last.state is State.ARRIVED
    assert abs(drive.sim.pose.theta) < 0.1


def test_the_way_that_is_left_shrinks_to_nothing():
    left_m = [step.progress.way_left_m for step in Drive(OPEN).until_end(goal_at(2.0, 0.0), 15).steps]
    known = [value for value in left_m if math.isfinite(value)]
    assert len(known) > 0.9 * len(left_m)
    assert known[0] == pytest.approx(2.0, abs=0.1)
    assert known[-1] < 0.05
    assert max(np.diff(known)) < 0.05


@pytest.mark.parametrize(
    ("plan", "navigation", "goal", "way_m"),
    [
        (box((2.0, 0.0), 6.0, 1.0), NAVIGATION, goal_at(4.0, 0.0), 4.0),  # between walls that make it count as longer
        (OPEN, NAVIGATION, goal_at(300.0, 400.0), 500.0),  # most of it beyond the map
        (ACROSS, KHATIB, goal_at(2.0, 0.0), 2.0),
    ],
    ids=["between walls", "far away", "khatib"],
)
def test_the_way_that_is_left_is_told_in_metres(plan, navigation, goal, way_m):
    drive = Drive(plan, navigation=navigation)
    drive.step(goal)
    while not math.isfinite(drive.last.way_left_m) or len(drive.steps) < 10:
        drive.step(goal)
    assert drive.moved_m() < 0.1
    assert drive.last.way_left_m == pytest.approx(way_m, abs=0.15, rel=0.01)


def test_the_way_around_a_wall_is_about_as_long_as_it_was_told():
    drive = Drive(ACROSS).until_end(goal_at(2.0, 0.0), 30)
    told_m = [step.progress.way_left_m for step in drive.steps if math.isfinite(step.progress.way_left_m)]
    assert drive.last.state is State.ARRIVED
    assert drive.moved_m() == pytest.approx(max(told_m), rel=0.15)
    assert told_m[0] > 2 * math.hypot(1.0, 1.0)


def test_the_same_steps_give_the_same_velocities_to_the_bit():
    goal = goal_at(2.5, 0.0, 1.0)
    first, again, other = (Drive(BESIDE, seed=seed).until_end(goal) for seed in (3, 3, 4))
    assert first.twists == again.twists
    assert [step.progress for step in first.steps] == [step.progress for step in again.steps]
    assert first.twists != other.twists


def test_velocities_are_whole_mm_and_degrees_a_second_within_the_limits():
    twists = np.array(Drive(BESIDE).until_end(goal_at(2.5, 0.3, 2.0)).twists)
    whole = twists * 1000, np.degrees(twists)
    assert np.abs(whole[0][:, 0] - np.round(whole[0][:, 0])).max() < 1e-6
    assert np.abs(whole[1][:, 1] - np.round(whole[1][:, 1])).max() < 1e-6
    assert 0.4 < np.abs(twists[:, 0]).max() <= BASE.max_speed_mps
    assert np.abs(twists[:, 1]).max() <= BASE.max_yaw_rate_radps


@pytest.mark.parametrize(
    ("plan", "goal", "navigation", "reason"),
    [
        (CELL, goal_at(2.5, 0.0), NAVIGATION, Reason.ENCLOSED),
        (PILLAR, goal_at(2.0, 0.0), NAVIGATION, Reason.OCCUPIED),
        (PILLAR, goal_at(2.0, 0.0), KHATIB, Reason.NO_PROGRESS),
    ],
)
def test_a_goal_out_of_reach_ends_with_the_reason_and_the_robot_stays(plan, goal, navigation, reason):
    drive = Drive(plan, navigation=navigation).until_end(goal, 60)
    assert (drive.last.state, drive.last.reason) == (State.BLOCKED, reason)
    assert not drive.sim.contact
    ended = drive.last
    drive.for_s(goal, 1.0)
    assert set(drive.twists[-21:]) == {(0.0, 0.0)}
    assert {step.progress for step in drive.steps[-20:]} == {ended}


def test_a_goal_that_ended_stays_so_also_when_the_robot_is_pushed_away():
    drive = Drive(OPEN).until_end(goal_at(0.5, 0.0), 10)
    stamp_ns = drive.sim.stamp_ns
    for tick in range(1, 40):
        odometry = Pose2D(0.5 + 0.01 * tick, 0.0, 0.0)
        twist, progress = drive.navigator.step(stamp_ns + tick * S // 20, None, odometry, goal_at(0.5, 0.0))
        assert (twist, progress.state) == (Twist2D(), State.ARRIVED)


@pytest.mark.parametrize("navigation", [NAVIGATION, KHATIB])
def test_a_goal_already_reached_is_arrived_at_within_a_second_without_moving(navigation):
    drive = Drive(OPEN, navigation=navigation).until_end(goal_at(0.0, 0.0), 2)
    assert drive.last.state is State.ARRIVED
    assert drive.sim.stamp_ns <= S
    assert set(drive.twists) == {(0.0, 0.0)}


def test_another_goal_takes_the_place_of_one_that_runs():
    drive = Drive(OPEN).for_s(goal_at(5.0, 0.0, name="first"), 2)
    second = goal_at(1.0, -1.0, 1.0, name="second")
    drive.until_end(second, 20)
    assert (drive.last.state, drive.last.goal_id) == (State.ARRIVED, "second")
    assert is_at(drive.sim.pose, second)


def test_a_goal_moved_under_the_same_id_is_another():
    drive = Drive(OPEN).until_end(goal_at(0.5, 0.0), 10)
    moved = goal_at(0.5, 0.6)
    assert is_at(drive.until_end(moved, 15).sim.pose, moved)


def test_the_same_place_under_another_id_is_driven_to_anew():
    drive, goal = Drive(OPEN).until_end(goal_at(0.5, 0.0), 10), goal_at(0.5, 0.0, name="again")
    drive.sim.command(Twist2D(-0.3, 0.0))
    drive.sim.step_to(drive.sim.stamp_ns + 2 * S)
    drive.for_s(goal_at(0.5, 0.0), 1.0)
    away_m = drive.sim.pose.x_m
    assert (drive.last.state, drive.last.goal_id) == (State.ARRIVED, "goal")
    drive.until_end(goal, 10)
    assert (drive.last.state, drive.last.goal_id) == (State.ARRIVED, "again")
    assert away_m < 0.2
    assert is_at(drive.sim.pose, goal)


def test_what_was_seen_is_kept_from_goal_to_goal():
    drive = Drive(PILLAR).for_s(goal_at(0.0, 0.0), 1)
    known = len(drive.navigator.seen_points())
    drive.scan_of = lambda scan: None
    drive.for_s(goal_at(0.0, -1.0, name="next"), 0.2)
    assert known == len(drive.navigator.seen_points()) > 5


def test_no_goal_can_be_made_of_nan():
    for broken in (math.nan, math.inf):
        with pytest.raises(ValueError, match="finite"):
            goal_at(broken, 0.0)
    with pytest.raises(ValueError, match="tolerance"):
        goal_at(1.0, 0.0, heading_tolerance=math.nan)


@pytest.mark.parametrize("stamp_ns", [5 * S, 5 * S - 1])
def test_a_stamp_that_does_not_rise_is_refused_and_changes_nothing(stamp_ns):
    navigators = [Navigator(NAVIGATION, BASE) for _ in range(2)]
    goal = goal_at(2.0, 0.5)
    for navigator in navigators:
        navigator.step(5 * S, free_scan(5 * S), HERE, goal)
    with pytest.raises(RefusedError, match=f"stamp_ns: expected more than {5 * S}, got {stamp_ns}"):
        navigators[0].step(stamp_ns, None, HERE, goal_at(-1.0, 0.0, name="other"))
    for tick in range(1, 10):
        now_ns = 5 * S + tick * S // 20
        answers = [navigator.step(now_ns, free_scan(now_ns), HERE, goal) for navigator in navigators]
        assert answers[0] == answers[1]


@pytest.mark.parametrize(
    ("pose", "rear", "said"),
    [
        (Pose2D(1e5, 0.0), None, r"pose: expected coordinates up to 50000 m, got Pose2D\(x_m=100000"),
        (HERE, [(math.nan, 0.0)], "rear_points_m: expected coordinates up to 50000 m, got nan"),
        (HERE, [(-0.5, 0.0), (0.0, -1e300)], r"rear_points_m: expected coordinates up to 50000 m, got -1e\+300"),
    ],
)
def test_what_no_step_can_be_made_of_is_refused_and_changes_nothing(pose, rear, said):
    navigators = [Navigator(NAVIGATION, BASE) for _ in range(2)]
    goal = goal_at(1.0, 0.0)
    with pytest.raises(RefusedError, match=said):
        navigators[0].step(S, free_scan(S), pose, goal, rear)
    answers = [navigator.step(S, free_scan(S), HERE, goal) for navigator in navigators]
    assert answers[0] == answers[1]


def test_a_goal_that_jumps_move_beyond_all_maps_is_refused_and_another_is_not():
    navigator = Navigator(NAVIGATION, BASE)
    far = Pose2D(FARTHEST_M, 0.0)
    navigator.step(S, None, far, Goal("there", far))
    with pytest.raises(
        RefusedError, match=r"^goal far, where jumps of the odometry moved it: expected coordinates up to"
    ):
        navigator.step(2 * S, None, Pose2D(-FARTHEST_M, 0.0), Goal("far", far))
    _, progress = navigator.step(3 * S, None, Pose2D(-FARTHEST_M, 0.0), Goal("near", Pose2D(2.0 - FARTHEST_M, 0.0)))
    assert progress.state is State.DRIVING


@pytest.mark.parametrize("nothing", [[], (), np.zeros(0), np.zeros((0, 2)), None], ids=repr)
def test_a_rear_sonar_that_sees_nothing_is_no_reason_to_refuse(nothing):
    navigators = [Navigator(NAVIGATION, BASE) for _ in range(2)]
    goal = goal_at(1.0, 0.0)
    answers = [
        navigator.step(S, free_scan(S), HERE, goal, *rear) for navigator, rear in zip(navigators, ((nothing,), ()))
    ]
    assert answers[0] == answers[1]


def test_before_the_first_goal_there_is_no_way():
    navigator = Navigator(NAVIGATION, BASE)
    assert navigator.way(5.0).shape == (0, 2)
    assert navigator.seen_points().shape == (0, 2)


@pytest.mark.parametrize(("sent", "state"), [(Twist2D(), State.DRIVING), (None, State.BLOCKED)])
def test_what_others_keep_it_from_costs_no_patience(sent, state):
    """Without the word that its commands do not reach the robot, it takes the standstill for its own failure."""
    navigator, goal = Navigator(NavigationConfig(patience_s=2.0), BASE), goal_at(3.0, 0.0)
    for tick in range(100):
        stamp_ns = tick * S // 20
        _, progress = navigator.step(stamp_ns, free_scan(stamp_ns), HERE, goal, sent=sent if tick else None)
    assert progress.state is state


def test_a_robot_that_is_held_and_sees_nothing_new_is_told_to_stand():
    navigator, goal = Navigator(NAVIGATION, BASE), goal_at(3.0, 0.0)
    scan, answers = free_scan(0), []
    for tick in range(1, 41):
        answers.append(navigator.step(tick * S // 20, scan, HERE, goal, sent=Twist2D())[0])
    assert any(twist.v_mps > 0 for twist in answers[:10])
    assert set(answers[20:]) == {Twist2D()}


@pytest.mark.parametrize("points", [[1.0, 2.0], [[1.0, 2.0, 3.0, 4.0]], np.zeros((2, 4))])
def test_rear_points_of_another_shape_are_refused(points):
    with pytest.raises(RefusedError, match=r"rear_points_m: expected shape \[k, 2\]"):
        Navigator(NAVIGATION, BASE).step(S, None, HERE, goal_at(3.0, 0.0), points)
