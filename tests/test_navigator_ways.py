# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The navigator in worlds where a robot sticks or scrapes: reached without a contact, by the field that the config
says, and with what is wrong with odometry and commands."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.maze_shapes import box, wall, walls

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.config.navigation import P3DX_FOOTPRINT_M
from edgefusion.navigation.progress import Reason, State
from edgefusion.sim.laser import LaserSpec
from edgefusion.types import Pose2D
from navigator_drives import HERE, KHATIB, OPEN, Drive, S, goal_at, is_at, off, to_segments_m

TRAP = walls([(1.0, 0.8), (2.4, 0.8), (2.4, -0.8), (1.0, -0.8)])
BLIND_ALLEY = walls([(1.0, 0.6), (4.0, 0.6), (4.0, -0.6), (1.0, -0.6)])
SLALOM = np.vstack([box((1.3, 0.25), 0.4, 0.6), box((2.6, -0.25), 0.4, 0.6)])
SIDES = np.vstack([box((2.5, 0.9), 0.4, 0.4), box((2.0, -1.2), 0.4, 0.4)])
DOORWAY_M = 2 * P3DX_FOOTPRINT_M[0][1] + 0.08


def doorway(x_m, y_m, slant):
    """A wall across the way that is too long to be driven around, and the doorway."""
    along = np.array([math.sin(slant), math.cos(slant)])
    a, b, c, d = (tuple(np.array([x_m, y_m]) + s * along) for s in (-6.0, -DOORWAY_M / 2, DOORWAY_M / 2, 6.0))
    return np.vstack([wall(a, b), wall(c, d)])


def seen_off_m(drive, plan, odometry_in_plan):
    """How far the farthest of what the navigator says it saw is from the plan."""
    seen = drive.navigator.seen_points()
    assert len(seen) > 20
    poses = [odometry_in_plan.compose(Pose2D(x, y, 0.0)) for x, y in seen]
    return to_segments_m(np.array([(pose.x_m, pose.y_m) for pose in poses]), plan).max()


@pytest.mark.parametrize(
    ("plan", "goal", "laser"),
    [
        (TRAP, goal_at(3.6, 0.0), None),
        (BLIND_ALLEY, goal_at(5.2, 0.0), LaserSpec(range_max_m=1.5)),
        (doorway(1.8, 0.3, 0.35), goal_at(3.4, 0.2, 1.0), None),
        (doorway(1.6, -0.2, -0.6), goal_at(3.2, 0.0, -2.0), None),
        (SLALOM, goal_at(3.6, 0.0), None),
    ],
    ids=["trap", "blind alley", "doorway left", "doorway right", "slalom"],
)
def test_what_sticks_a_plain_field_is_reached_without_a_contact(plan, goal, laser):
    drive = Drive(plan, laser=laser).until_end(goal, 60)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.pose, goal)
    assert drive.sim.clearance_m > 0


def test_a_dead_end_that_was_not_known_is_entered_and_left_again():
    drive = Drive(BLIND_ALLEY, laser=LaserSpec(range_max_m=1.5)).for_s(goal_at(5.2, 0.0), 9)
    deepest_m = max(step.pose.x_m for step in drive.steps if abs(step.pose.y_m) < 0.6)
    assert deepest_m > 1.5
    way = drive.navigator.way(20.0)
    assert (np.abs(way[:, 1]) > 0.6).any()  # around it


def test_a_way_that_opens_after_a_while_is_driven_and_not_manoeuvred_out_of():
    """Shut just when the robot sets out: to stand without a way is not to be stalled."""
    open_, shut = (np.vstack([box((2.0, 0.0), 6.0, 2.0), *more]) for more in ((), (wall((2.0, -1.1), (2.0, 1.1)),)))
    drive = Drive(lambda stamp_ns: shut if 0.2 * S <= stamp_ns <= 2.8 * S else open_)
    drive.until_end(goal_at(4.0, 0.0), 20)
    assert drive.last.state is State.ARRIVED
    notes = [step.progress.note for step in drive.steps]
    assert notes.count("looks for a way") > 40
    assert not {"looks for a way out", "manoeuvres"} & set(notes)


def test_the_papers_field_reaches_a_goal_on_open_ground():
    goal = goal_at(2.0, 1.0, 2.0)
    drive = Drive(OPEN, navigation=KHATIB).until_end(goal, 20)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.pose, goal)
    assert drive.navigator.way(3.0).shape == (0, 2)  # it plans none


def test_the_papers_field_is_pushed_aside_by_what_is_near():
    aside_m = []
    for plan in (OPEN, box((1.5, 0.75), 0.3, 0.3)):
        drive = Drive(plan, navigation=KHATIB).for_s(goal_at(3.0, 0.0), 8)
        assert not drive.sim.contact
        aside_m.append(min(step.pose.y_m for step in drive.steps))
    assert aside_m[0] == pytest.approx(0.0, abs=0.01)
    assert aside_m[1] < -0.02


def test_the_papers_field_sticks_in_a_trap_and_says_so_in_time():
    drive = Drive(TRAP, navigation=KHATIB).until_end(goal_at(3.6, 0.0), 60)
    assert (drive.last.state, drive.last.reason) == (State.BLOCKED, Reason.NO_PROGRESS)
    assert not drive.sim.contact
    assert abs(drive.sim.pose.y_m) < 0.8
    assert drive.sim.pose.x_m < 2.4


def test_a_goal_beyond_the_map_is_reached_too():
    quick = BaseConfig(max_speed_mps=8.0, acceleration_mps2=4.0)
    goal, plan = goal_at(66.0, 8.0, 0.5), np.vstack([OPEN, box((33.0, 4.0), 3.0, 6.0)])
    coarse = NavigationConfig(cell_m=0.1)
    drive = Drive(plan, base=quick, navigation=coarse, laser=LaserSpec(mixed=0.0)).until_end(goal, 40)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.pose, goal)


@pytest.mark.parametrize("jump", [Pose2D(0.3, 0.0, 0.0), Pose2D(-0.2, 0.22, 0.0), Pose2D(0.0, 0.3, 0.4)])
def test_after_a_jump_of_the_odometry_the_goal_is_where_odometry_says_and_things_are_where_they_were(jump):
    goal = goal_at(4.5, 0.0, 0.5)
    drive = Drive(SIDES, jump_ns=4 * S, jump=jump).for_s(goal, 3.9)
    assert seen_off_m(drive, SIDES, HERE) < 0.06
    drive.for_s(goal, 1.0)
    way = drive.navigator.way(10.0)
    here = drive.steps[-1].odometry
    assert math.dist(way[0], (here.x_m, here.y_m)) < 0.1
    assert math.dist(way[-1], (4.5, 0.0)) < 0.15
    drive.until_end(goal)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.odometry, goal)
    assert off(drive.sim.pose, goal)[0] > 0.2
    assert seen_off_m(drive, SIDES, HERE.relative_to(jump)) < 0.06
    assert seen_off_m(drive, SIDES, HERE) > 0.2
    assert drive.sim.clearance_m > 0


def test_the_way_leads_from_the_robot_around_what_was_seen_to_the_goal():
    drive = Drive(TRAP).for_s(goal_at(3.6, 0.0), 3)
    way = drive.navigator.way(20.0)
    here = drive.sim.odometry
    assert math.dist(way[0], (here.x_m, here.y_m)) < 0.1
    assert math.dist(way[-1], (3.6, 0.0)) < 0.1
    assert np.hypot(*np.diff(way, axis=0).T).max() < 0.1
    assert to_segments_m(way, TRAP).min() > 0.2
    short = drive.navigator.way(1.0)
    assert np.hypot(*np.diff(short, axis=0).T).sum() == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("delay_s", [0.0, 0.2])
def test_commands_that_take_effect_late_are_reckoned_with(delay_s):
    goal = goal_at(3.6, 0.0, 1.5)
    drive = Drive(SLALOM, base=BaseConfig(command_delay_s=delay_s)).until_end(goal, 60)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.pose, goal)
    assert drive.sim.clearance_m > 0.015
