# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the navigator makes of what it sees, and does not see: missing and blind scans, single beams, what appears, what
is behind, and who walks by."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.maze_shapes import box, disc, walls
from benchmarks.maze_world import PERSON_RADIUS_M, Person
from benchmarks.nav_run import STOOD_NS

from edgefusion.config import NavigationConfig
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.progress import Reason, State
from edgefusion.sim.laser import LaserSpec
from edgefusion.types import Pose2D, Scan, Twist2D
from navigator_drives import BASE, HERE, NAVIGATION, OPEN, Drive, S, goal_at, is_at

EXACT = LaserSpec(sigma_m=0.0, dropped=0.0, mixed=0.0)
TAIL_POST = (-0.355, 0.0)
"""Behind the tail, but within the circle of its corners."""


def filled(value, where=slice(None)):
    """Scans of which these beams read nothing but this."""

    def change(scan):
        if scan is None:
            return None
        ranges_m = scan.ranges_m.copy()
        ranges_m[where] = value
        return replace(scan, ranges_m=ranges_m)

    return change


def test_without_a_scan_it_stands_and_says_why():
    drive = Drive(OPEN)
    drive.scan_of = lambda scan: None
    drive.for_s(goal_at(2.0, 0.0), 2)
    assert set(drive.twists) == {(0.0, 0.0)}
    assert {(step.progress.state, step.progress.note) for step in drive.steps} == {
        (State.DRIVING, "no scan that is new enough")
    }


def test_it_stands_while_scans_are_too_old_and_goes_on_when_they_come_back():
    goal = goal_at(3.0, 0.0)
    drive = Drive(OPEN).for_s(goal, 2.5)
    kept = drive.sim.newest_scan()
    drive.scan_of = lambda scan: kept
    begun = len(drive.steps)
    drive.for_s(goal, 2.5)
    for step in drive.steps[begun:]:
        stale = step.stamp_ns - kept.stamp_ns > NAVIGATION.max_scan_age_s * S
        assert (step.twist == Twist2D()) == stale == ("no scan" in step.progress.note)
    assert drive.sim.twist == Twist2D()
    drive.scan_of = lambda scan: scan
    drive.until_end(goal, 15)
    assert drive.last.state is State.ARRIVED
    assert is_at(drive.sim.pose, goal)


@pytest.mark.parametrize("seconds", [5.0, 35.0])
def test_an_outage_longer_than_its_patience_is_no_lack_of_progress(seconds):
    drive, goal = Drive(OPEN).for_s(goal_at(2.0, 0.0), 2), goal_at(2.0, 0.0)
    drive.scan_of = lambda scan: None
    drive.for_s(goal, seconds)
    drive.scan_of = lambda scan: scan
    assert drive.until_end(goal, 15).last.state is State.ARRIVED


def test_a_scan_from_another_time_is_none():
    for off_ns in (-2 * S, 10 * S):
        drive = Drive(box((1.2, 0.0), 0.4, 2.0))
        drive.scan_of = lambda scan, off_ns=off_ns: scan and replace(scan, stamp_ns=scan.stamp_ns + off_ns)
        drive.for_s(goal_at(3.0, 0.0), 4)
        assert set(drive.twists) == {(0.0, 0.0)}


@pytest.mark.parametrize(("beams", "note"), [(slice(None), "no scan that is new enough"), (slice(80, 281), "")])
def test_beams_that_say_nothing_open_no_way_ahead(beams, note):
    """All of them: there is no scan. Those ahead: it drives only over ground that was seen."""
    drive = Drive(OPEN)
    drive.scan_of = filled(np.nan, beams)
    drive.for_s(goal_at(3.0, 0.0), 2)
    assert max(v_mps for v_mps, _ in drive.twists) == 0
    assert drive.moved_m() == 0
    assert note in drive.last.note


def test_beams_that_met_nothing_are_free():
    drive, goal = Drive(OPEN), goal_at(2.0, 0.0)
    drive.scan_of = filled(np.inf)
    drive.until_end(goal, 10)
    assert drive.last.state is State.ARRIVED
    assert max(v_mps for v_mps, _ in drive.twists) == 0.5


@pytest.mark.parametrize(("reading_m", "range_min_m"), [(0.13, 0.0), (-math.inf, 0.13)])
@pytest.mark.parametrize("beam", [150, 180, 215])
def test_a_single_near_beam_ahead_counts(reading_m, range_min_m, beam):
    """2 cm or less before the nose, from a laser 0.11 m behind that; -inf is as near as the laser can measure."""
    fastest = []
    for value in (np.inf, reading_m):
        navigator, ranges_m = Navigator(NAVIGATION, BASE), np.full(361, np.inf)
        ranges_m[beam] = value
        twists = [
            navigator.step(stamp_ns, _scan(stamp_ns, ranges_m, range_min_m), HERE, goal_at(3.0, 0.0))[0]
            for stamp_ns in range(0, S, S // 20)
        ]
        fastest.append(max(twist.v_mps for twist in twists))
    assert fastest[0] == 0.5
    assert fastest[1] < 0.01


def _scan(stamp_ns, ranges_m, range_min_m):
    return Scan(stamp_ns, ranges_m, -math.pi / 2, math.radians(0.5), range_min_m, 8.0)


def test_a_post_as_thin_as_a_beam_is_driven_around():
    goal = goal_at(3.2, 0.0)
    drive = Drive(box((1.8, 0.0), 0.012, 0.012)).until_end(goal, 30)
    assert drive.last.state is State.ARRIVED
    assert 0.02 < drive.sim.clearance_m < 0.5


def test_a_wall_that_appears_beyond_the_way_to_brake_is_not_touched():
    goal, appears_ns = goal_at(8.0, 0.0), 3 * S
    free = Drive(OPEN).for_s(goal, 3)
    assert free.sim.twist.v_mps == 0.5
    # 0.42 m to brake; what a scan and a command take: 0.05 + 0.04 + 0.05 + 0.05 s.
    face_m = free.sim.pose.x_m + 0.21 + 0.42 + 0.1 + NAVIGATION.margin_m
    there = box((face_m + 0.05, 0.0), 0.1, 8.0)
    drive = Drive(lambda stamp_ns: there if stamp_ns >= appears_ns else OPEN).for_s(goal, 5)
    assert not drive.sim.contact
    assert drive.sim.clearance_m < 0.2
    assert min(step.speed.v_mps for step in drive.steps[60:]) < 0.05


def test_the_rear_sonar_keeps_the_tail_off_what_the_laser_does_not_see():
    goal, contacts = goal_at(0.0, 0.0, math.pi / 2), []
    for sonar in (False, True):
        drive = Drive(box((TAIL_POST[0] - 0.01, 0.0), 0.02, 0.02))
        if sonar:
            drive.rear_of = lambda pose: [_in_base(TAIL_POST, pose)]
        drive.until_end(goal, 30)
        contacts.append(drive.sim.contact)
    assert contacts == [True, False]
    assert drive.last.state is State.ARRIVED  # not on the spot, but there
    assert is_at(drive.sim.pose, goal)


def _in_base(point, pose):
    seen = Pose2D(*point).relative_to(pose)
    return seen.x_m, seen.y_m


def _never_came_through(steps, point):
    """Whether a point of an empty convex room was never in view of the laser, nor under the hull, up to then; what is
    known is known by cells."""
    slack_m = 0.08
    for step in steps:
        seen = Pose2D(*point).relative_to(step.pose)
        under = -0.301 - slack_m < seen.x_m < 0.21 + slack_m and abs(seen.y_m) < 0.2125 + slack_m
        if under or seen.x_m > BASE.laser_pose[0] - slack_m:
            return False
    return True


def test_it_never_backs_over_ground_that_it_has_not_seen():
    """In a pocket, facing its end."""
    drive = Drive(walls([(-1.0, 0.55), (0.7, 0.55), (0.7, -0.55), (-1.0, -0.55)])).until_end(goal_at(-1.6, 0.0), 40)
    backwards = [k for k, step in enumerate(drive.steps) if step.twist.v_mps < 0]
    for k in backwards:
        tail = drive.steps[k].pose.compose(Pose2D(-0.301, 0.0, 0.0))
        assert not _never_came_through(drive.steps[: k + 1], (tail.x_m, tail.y_m))
    assert all(abs(drive.steps[k].pose.theta) > math.radians(20) for k in backwards)
    assert drive.last.state is State.ARRIVED
    assert not drive.sim.contact


def test_where_it_cannot_turn_it_gives_up_rather_than_back_out_blindly():
    pocket = walls([(-1.0, 0.31), (0.5, 0.31), (0.5, -0.31), (-1.0, -0.31)])
    drive = Drive(pocket, navigation=NavigationConfig(patience_s=8.0)).until_end(goal_at(-1.6, 0.0), 90)
    assert min(v_mps for v_mps, _ in drive.twists) >= 0
    assert (drive.last.state, drive.last.reason) == (State.BLOCKED, Reason.NO_PROGRESS)
    assert not drive.sim.contact


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("leaves_s", [0.0, 0.7, 1.4, 2.1])
def test_somebody_who_crosses_the_way_is_let_pass(side, leaves_s):
    person, goal = Person((2.0, -3.0 * side), (2.0, 3.0 * side), leaves_s), goal_at(4.0, 0.0)
    drive = Drive(lambda stamp_ns: np.vstack([OPEN, disc(person.at(stamp_ns), PERSON_RADIUS_M)]))
    drive.until_end(goal, 30)
    assert not drive.sim.contact or drive.sim.standing_ns >= STOOD_NS
    assert drive.sim.contact or drive.last.state is State.ARRIVED
