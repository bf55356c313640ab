# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who walks about: the velocity of a walking disc, the room that it is left, and that what stands is nobody."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))


from benchmarks.maze_shapes import box, disc

from edgefusion._core import ObstacleMap
from edgefusion.navigation.movers import ROOM_M, SPREAD_MPS, Movers
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.types import Pose2D

RADIUS_M = 0.25
S, PERIOD_NS = 1_000_000_000, 50_000_000
WALL = box((6.0, 0.0), 0.2, 9.0)


def at_origin(stamp_ns):
    return Pose2D()


def watched(plan_at, seconds, laser_at=at_origin, until_blind_s=math.inf, seed=0):
    """What a laser has made of a plan after so long, and the time of its last scan."""
    movers, map_, laser = Movers(), ObstacleMap(0.05), SimLaser(LaserSpec())
    map_.cover(0.0, 0.0, 5.0, 0.0)
    rng = np.random.default_rng(seed)
    for stamp_ns in range(S, S + round(seconds * S), PERIOD_NS):
        plan = plan_at((stamp_ns - S) / S) if stamp_ns - S < until_blind_s * S else WALL
        scan, _ = laser.scan(stamp_ns, plan, laser_at, rng)
        poses = np.array([(p.x_m, p.y_m, p.theta) for p in (laser_at(stamp_ns + int(dt)) for dt in scan.beam_dt_ns)])
        map_.insert(poses, scan.ranges_m, scan.angle_min, scan.angle_increment, 0.0, scan.range_max_m, stamp_ns)
        hit = np.isfinite(scan.ranges_m)
        angles = poses[hit, 2] + scan.angles[hit]
        ends = poses[hit, :2] + scan.ranges_m[hit, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        movers.see(scan, ends, laser_at(stamp_ns), map_)
    return movers, stamp_ns


def walking(x_m, y_m, vx, vy):
    """A disc that is there when the time begins, and walks."""
    return lambda time_s: np.vstack([WALL, disc((x_m + vx * time_s, y_m + vy * time_s), RADIUS_M)])


def centre_and_velocity(rims):
    assert len(rims) > 0 and len(rims) % 12 == 0
    return rims[:12, :2].mean(axis=0), rims[:12, 2:].mean(axis=0)


@pytest.mark.parametrize(
    ("x_m", "y_m", "vx", "vy"),
    [(3.0, -1.5, 0.0, 1.0), (2.5, 1.0, 0.5, -0.8), (5.0, 0.3, -1.2, 0.0), (2.0, -1.0, 0.0, 0.5)],
)
def test_a_walking_disc_is_a_mover_with_its_velocity_where_it_is(x_m, y_m, vx, vy):
    movers, last_ns = watched(walking(x_m, y_m, vx, vy), 1.5)
    rims = movers.at(last_ns)
    assert len(rims) == 12
    centre, velocity = centre_and_velocity(rims)
    time_s = (last_ns - S) / S
    assert velocity == pytest.approx((vx, vy), abs=0.12)
    assert centre == pytest.approx((x_m + vx * time_s, y_m + vy * time_s), abs=0.12)


def test_it_is_seen_as_well_from_a_robot_that_drives_and_turns():
    def laser_at(stamp_ns):
        time_s = (stamp_ns - S) / S
        return Pose2D(0.5 * time_s, 0.0, 0.3 * math.sin(2 * time_s))

    movers, last_ns = watched(walking(3.5, -1.5, 0.0, 1.0), 1.5, laser_at)
    assert centre_and_velocity(movers.at(last_ns))[1] == pytest.approx((0.0, 1.0), abs=0.15)


def test_where_it_will_be_is_straight_on_and_the_room_about_it_grows():
    movers, last_ns = watched(walking(3.0, -1.5, 0.0, 1.0), 1.5)
    now, velocity = centre_and_velocity(movers.at(last_ns))
    later, _ = centre_and_velocity(movers.at(last_ns + S))
    assert later == pytest.approx(now + velocity)
    for stamp_ns, room_m in ((last_ns, ROOM_M), (last_ns + S, ROOM_M + SPREAD_MPS)):
        rim = movers.at(stamp_ns)[:, :2]
        assert np.hypot(*(rim - rim.mean(axis=0)).T) == pytest.approx(room_m)
    spread = movers.at(last_ns)[:, 2:] - velocity
    assert np.hypot(*spread.T) == pytest.approx(SPREAD_MPS)


@pytest.mark.parametrize("seed", range(3))
def test_what_stands_never_is_a_mover_also_from_a_robot_that_drives(seed):
    plan = np.vstack([WALL, disc((3.0, 0.5), RADIUS_M), disc((2.0, -1.0), 0.1), box((4.0, -1.2), 0.5, 0.3, 0.4)])

    def laser_at(stamp_ns):
        time_s = (stamp_ns - S) / S
        return Pose2D(0.5 * time_s, 0.2 * math.sin(time_s), 0.5 * math.sin(3 * time_s))

    for seconds in (0.5, 1.0, 2.0, 3.0):
        for at in (at_origin, laser_at):
            movers, last_ns = watched(lambda time_s: plan, seconds, at, seed=seed)
            assert len(movers.at(last_ns)) == 0


def test_what_is_put_down_and_stands_is_no_mover():
    shown = np.vstack([WALL, disc((3.0, 0.0), RADIUS_M)])
    movers, last_ns = watched(lambda time_s: WALL if time_s < 1 else shown, 2.0)
    assert len(movers.at(last_ns)) == 0


@pytest.mark.parametrize(("vy", "moves"), [(0.1, False), (0.5, True), (2.0, True)])
def test_only_what_goes_at_a_walkers_pace_is_a_mover(vy, moves):
    movers, last_ns = watched(walking(3.0, -1.5, 0.0, vy), 1.2)
    assert (len(movers.at(last_ns)) > 0) is moves


def test_a_wall_that_moves_is_nobody():
    movers, last_ns = watched(lambda time_s: box((4.0 - time_s, 0.0), 0.2, 2.0), 1.5)
    assert len(movers.at(last_ns)) == 0


def test_two_who_walk_apart_are_two():
    both = lambda time_s: np.vstack([WALL, disc((3.0, 0.8 + time_s), 0.25), disc((3.0, -0.8 - time_s), 0.25)])  # noqa: E731
    movers, last_ns = watched(both, 1.2)
    rims = movers.at(last_ns)
    assert len(rims) == 24
    ways = sorted((rims[:12, 3].mean(), rims[12:, 3].mean()))
    assert ways == pytest.approx([-1.0, 1.0], abs=0.15)


def test_who_has_come_to_a_stop_moves_no_more():
    stops = lambda time_s: walking(3.0, -1.5, 0.0, 1.0)(min(time_s, 1.5))  # noqa: E731
    assert len(watched(stops, 1.4)[0].at(S + 14 * S // 10)) == 12
    movers, last_ns = watched(stops, 2.8)
    assert len(movers.at(last_ns)) == 0


def test_what_jumps_about_is_no_walker():
    def jumps(time_s):
        return walking(3.0, -1.2 if time_s < 0.8 else -1.65, 0.0, 1.0)(time_s)

    assert len(watched(jumps, 0.8)[0].at(S + 8 * S // 10)) == 12
    movers, last_ns = watched(jumps, 1.15)
    assert len(movers.at(last_ns)) == 0


def test_who_appears_far_away_is_somebody_else():
    def changes(time_s):
        return walking(3.0, -1.0, 0.0, 1.0)(time_s) if time_s < 1.0 else walking(3.0, 3.0, 0.0, 0.0)(time_s)

    movers, last_ns = watched(changes, 1.3)
    centre, velocity = centre_and_velocity(movers.at(last_ns))
    assert centre == pytest.approx((3.0, -1.0 + (last_ns - S) / S), abs=0.15)
    assert velocity == pytest.approx((0.0, 1.0), abs=0.15)


def test_who_is_gone_from_the_middle_of_the_view_is_forgotten_soon():
    movers, last_ns = watched(walking(3.0, -1.0, 0.0, 1.0), 1.5, until_blind_s=1.0)
    assert len(movers.at(last_ns)) == 12
    movers, last_ns = watched(walking(3.0, -1.0, 0.0, 1.0), 2.0, until_blind_s=1.0)
    assert len(movers.at(last_ns)) == 0


def test_without_anything_in_view_there_is_nobody():
    movers, last_ns = watched(lambda time_s: box((0.0, 0.0), 100.0, 100.0), 0.5)
    assert movers.at(last_ns).shape == (0, 4)
