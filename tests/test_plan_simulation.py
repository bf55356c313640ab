# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base with a laser in a floor plan: paces, delays, errors of the wheels, contacts."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.plan_simulation import WATCHED_M, PlanSimulation, PlanSpec
from edgefusion.sim.robot import BaseSpec
from edgefusion.types import Pose2D, Twist2D

BOX = ((0.2, 0.1), (-0.3, 0.1), (-0.3, -0.1), (0.2, -0.1))
EXACT = LaserSpec(sigma_m=0.0, dropped=0.0, mixed=0.0)
SPEC = PlanSpec(BOX, BaseSpec(acceleration_mps2=1e6, yaw_acceleration_radps2=1e6), EXACT)
WALL = np.array([[3.0, -5.0, 3.0, 5.0]])
START = Pose2D(1.0, 0.0, 0.0)
FORWARD = Twist2D(0.2, 0.0)
S = 1_000_000_000


def driven(spec, seconds, twist=FORWARD, plan=WALL, seed=0):
    sim = PlanSimulation(plan, START, spec, seed)
    sim.command(twist)
    for tick in range(1, round(seconds * 20) + 1):
        sim.step_to(tick * S // 20)
        sim.newest_scan()
    return sim


def changed(**options):
    return dataclasses.replace(SPEC, **options)


def ahead_m(scan):
    return float(scan.ranges_m[len(scan.ranges_m) // 2])


def test_the_odometry_begins_at_the_start_and_is_the_truth_without_errors():
    sim = driven(SPEC, 2, Twist2D(0.2, 0.1))
    believed = START.compose(sim.odometry)
    assert (believed.x_m, believed.y_m) == pytest.approx((sim.pose.x_m, sim.pose.y_m))
    assert sim.odometry != Pose2D()


def test_the_laser_looks_from_where_it_is_mounted():
    sim = driven(changed(laser_pose=Pose2D(0.1, 0.0, math.pi / 2)), 1, Twist2D())
    assert sim.newest_scan().ranges_m[0] == pytest.approx(1.9)  # its first beam points ahead now
    assert not np.isfinite(ahead_m(sim.newest_scan()))


def test_scans_come_at_their_pace_and_as_late_as_the_line_is_slow():
    sim = PlanSimulation(WALL, START, changed(scan_period_ns=S // 5, line_ns=S * 19 // 100))
    stamps, ages = set(), []
    for tick in range(100, 400):
        sim.step_to(tick * S // 100)
        scan = sim.newest_scan()
        if scan.stamp_ns not in stamps:
            ages.append((sim.stamp_ns - scan.stamp_ns) / S)
        stamps.add(scan.stamp_ns)
    assert len(stamps) == pytest.approx(15, abs=1)
    assert {b - a for a, b in zip(sorted(stamps), sorted(stamps)[1:])} == {S // 5}
    assert 0.19 < min(ages[1:]) <= max(ages[1:]) < 0.22


def test_before_the_first_scan_has_come_there_is_none():
    assert PlanSimulation(WALL, START, SPEC).newest_scan() is None


def test_a_scan_shows_where_the_robot_was_at_its_stamp():
    sim = driven(changed(line_ns=S // 2), 3)
    scan = sim.newest_scan()
    assert ahead_m(scan) == pytest.approx(2.0 - 0.2 * scan.stamp_ns / S, abs=0.004)


def test_the_same_seed_and_commands_give_the_same_drive_and_another_seed_another():
    noisy = changed(laser=LaserSpec(), base=BaseSpec(slip_m=0.01))
    runs = [driven(noisy, 1, seed=seed) for seed in (3, 3, 4)]
    scans = [run.newest_scan().ranges_m.tobytes() for run in runs]
    assert (runs[0].pose, scans[0]) == (runs[1].pose, scans[1])
    assert runs[0].pose != runs[2].pose
    assert scans[0] != scans[2]


def test_a_scan_does_not_depend_on_which_others_were_asked_for():
    all_seen, asked_once = (
        driven(changed(laser=LaserSpec()), 1),
        PlanSimulation(WALL, START, changed(laser=LaserSpec())),
    )
    asked_once.command(Twist2D(0.2, 0.0))
    asked_once.step_to(S)
    np.testing.assert_array_equal(asked_once.newest_scan().ranges_m, all_seen.newest_scan().ranges_m)


def test_a_command_takes_effect_after_the_delay():
    sim = PlanSimulation(WALL, START, changed(command_delay_ns=S // 5))
    sim.command(Twist2D(0.2, 0.0))
    sim.step_to(S // 5)
    assert sim.twist == Twist2D()
    sim.step_to(S // 5 + S)
    assert sim.pose.x_m == pytest.approx(START.x_m + 0.2)


def test_commands_keep_their_order_and_distance_through_the_delay():
    sim = PlanSimulation(WALL, START, changed(command_delay_ns=S // 2))
    sim.command(Twist2D(0.2, 0.0))
    sim.step_to(S // 4)
    sim.command(Twist2D())
    sim.step_to(2 * S)
    assert sim.pose.x_m == pytest.approx(START.x_m + 0.2 / 4)


def test_a_scale_error_makes_the_way_longer_than_counted():
    base = dataclasses.replace(SPEC.base, left_drift_percent=2.0, right_drift_percent=2.0)
    sim = driven(changed(base=base), 5)
    assert sim.odometry.x_m == pytest.approx(1.0)
    assert sim.pose.x_m == pytest.approx(START.x_m + 1.02)


def test_the_odometry_jumps_at_its_time_and_the_robot_does_not():
    spec = changed(jump_ns=S, jump=Pose2D(0.0, 0.3, 0.0))
    before, after = driven(spec, 0.95), driven(spec, 1)
    assert before.odometry.y_m == 0
    assert after.odometry.y_m == pytest.approx(0.3)
    assert (after.pose.y_m, after.odometry.x_m) == pytest.approx((0.0, 0.2))


def test_the_smallest_clearance_stays_and_a_contact_ends_the_time():
    there = driven(changed(hull_m=BOX), 7)
    back = driven(SPEC, 7)
    back.command(Twist2D(-0.2, 0.0))
    back.step_to(9 * S)
    assert there.clearance_m == pytest.approx(0.4)
    assert back.clearance_m == there.clearance_m
    hit = driven(SPEC, 12)
    assert hit.contact
    assert hit.stamp_ns / S == pytest.approx(9.0, abs=0.02)  # the nose meets the wall, 1.8 m ahead
    assert hit.pose.x_m == pytest.approx(2.8, abs=0.003)


def test_clearances_beyond_the_watched_ones_are_not_told():
    assert driven(SPEC, 0.5).clearance_m == WATCHED_M


def test_something_that_walks_into_a_standing_robot_touches_it():
    def door(stamp_ns):
        return WALL - [0.5 * stamp_ns / S, 0, 0.5 * stamp_ns / S, 0]

    sim = driven(SPEC, 10, Twist2D(), plan=door)
    assert sim.contact
    assert sim.stamp_ns / S == pytest.approx(3.6, abs=0.02)
    assert sim.standing_ns == sim.stamp_ns
    assert ahead_m(sim.newest_scan()) == pytest.approx(2.0 - 0.5 * sim.newest_scan().stamp_ns / S, abs=0.005)


def test_it_knows_for_how_long_the_robot_has_stood():
    sim = driven(SPEC, 1)
    assert sim.standing_ns == 0
    sim.command(Twist2D())
    sim.step_to(3 * S)
    assert sim.standing_ns == pytest.approx(2 * S, abs=2e7)


@pytest.mark.parametrize("options", [{"scan_period_ns": 0}, {"line_ns": -1}, {"command_delay_ns": -1}, {"jump_ns": -1}])
def test_impossible_times_are_refused(options):
    with pytest.raises(RefusedError, match=next(iter(options))):
        changed(**options)
