# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds that are hard for a navigator: by seed, as their families promise, and to be reached where they say so."""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import mazes
from benchmarks.maze_feasible import reachable
from benchmarks.maze_shapes import box, clutter, disc, room, wall
from benchmarks.maze_table import is_right, missed, row
from benchmarks.maze_world import PERSON_RADIUS_M, WALK_MPS, Person
from benchmarks.maze_worlds import DOORWAY_M, FAMILIES, GAP_M, GOAL_TO_WALL_M, JUMP_M, ROBOT_WIDTH_M, make
from benchmarks.nav_run import Outcome, Run

from edgefusion.config.navigation import P3DX_FOOTPRINT_M
from edgefusion.navigation.progress import Reason
from edgefusion.sim.hull import Hull, bounded
from edgefusion.types import Pose2D

HULL = Hull(P3DX_FOOTPRINT_M)
TURNING_M = float(np.hypot(*HULL.corners_m.T).max())
SEEDS = range(12)
REACHABLE = [family for family in FAMILIES if not make(family, 0).reasons]
DEMANDED = [family for family in FAMILIES if make(family, 0).demanded]


def worlds(family):
    return [make(family, seed) for seed in SEEDS]


def to_nearest_m(world, pose, stamp_ns=0):
    """From the axle to the nearest that stands or walks."""
    point = Hull(((1e-6, 0), (0, 1e-6), (-1e-6, 0)))
    return point.clearance_m(pose, bounded(world.segments_at(stamp_ns)))


def gap_m(world):
    """Between the two pieces of the wall across the room: after the room's four segments, four a piece."""
    pieces = world.static[4:8], world.static[8:12]
    return min(math.dist(a, b) for a in pieces[0][:, :2] for b in pieces[1][:, :2])


def run(outcome, reason="", time_s=1.0):
    return Run(outcome, reason, time_s, 0.1, np.zeros((2, 3)))


@pytest.mark.parametrize("family", FAMILIES)
def test_the_same_seed_gives_the_same_world_and_another_seed_another(family):
    first, again, other = make(family, 3), make(family, 3), make(family, 4)
    assert first.static.tobytes() == again.static.tobytes()
    assert replace(first, static=None) == replace(again, static=None)
    assert (first.start, first.goal) != (other.start, other.goal)
    assert first.name == f"{family}-3"


def test_there_are_at_least_200_worlds():
    assert len(FAMILIES) * 20 >= 200


@pytest.mark.parametrize("family", FAMILIES)
def test_the_robot_can_turn_where_it_starts(family):
    assert min(to_nearest_m(world, world.start) for world in worlds(family)) > TURNING_M + 0.1


@pytest.mark.parametrize("family", REACHABLE)
def test_the_robot_can_turn_where_the_goal_is(family):
    assert min(to_nearest_m(world, world.goal) for world in worlds(family)) > TURNING_M + 0.02


@pytest.mark.parametrize("family", DEMANDED)
def test_the_goal_can_be_reached_exactly_where_the_world_says_so(family):
    world = make(family, 1)
    assert reachable(world.static, HULL, world.start, world.goal) is not bool(world.reasons)


def test_the_search_knows_the_hulls_width_and_that_it_is_no_circle():
    def door(width_m):
        half = width_m / 2
        return np.vstack([room(4, 3), wall((2, -0.2), (2, 1.5 - half)), wall((2, 1.5 + half), (2, 3.2))])

    start, goal = Pose2D(0.8, 1.5, 2.0), Pose2D(3.2, 1.5, 1.0)
    assert ROBOT_WIDTH_M + 0.05 < 2 * TURNING_M
    assert reachable(door(ROBOT_WIDTH_M + 0.05), HULL, start, goal)
    assert not reachable(door(ROBOT_WIDTH_M - 0.01), HULL, start, goal)


def test_the_search_knows_which_way_the_robot_can_stand():
    corridor = box((2.0, 0.3), 4.0, 0.6)
    assert reachable(corridor, HULL, Pose2D(0.5, 0.3, 0.0), Pose2D(3.5, 0.3, 0.0))
    assert not reachable(corridor, HULL, Pose2D(0.5, 0.3, 0.0), Pose2D(3.5, 0.3, math.pi))


def test_doorways_are_as_wide_as_they_should_be_and_never_square_to_the_room():
    for world in worlds("doorway"):
        assert gap_m(world) == pytest.approx(DOORWAY_M)
        along = world.static[4, 2:] - world.static[4, :2]
        assert 0.1 < abs(math.sin(2 * math.atan2(along[1], along[0]))) <= 1
    assert pytest.approx(ROBOT_WIDTH_M + 0.08) == DOORWAY_M
    for world in worlds("narrow"):
        assert gap_m(world) < 0.91 * ROBOT_WIDTH_M


def test_tight_doorways_are_wider_than_the_robot_by_less_than_it_is_made_for():
    gaps = [gap_m(world) - ROBOT_WIDTH_M for world in worlds("tight_doorway")]
    assert min(gaps) >= 0.03 and max(gaps) <= 0.07
    assert max(gaps) - min(gaps) > 0.02


def test_through_a_tight_doorway_the_robot_fits_straight():
    for world in worlds("tight_doorway"):
        ends = world.static[4:12].reshape(-1, 2)
        a, b = min(itertools.product(ends[:8], ends[8:]), key=lambda pair: math.dist(*pair))
        across = math.atan2(*(b - a)[::-1]) + math.pi / 2
        x_m, y_m = (a + b) / 2
        for off_m in np.linspace(-0.6, 0.6, 25):
            pose = Pose2D(x_m + off_m * math.cos(across), y_m + off_m * math.sin(across), across)
            assert HULL.clearance_m(pose, bounded(world.static)) > 0.01


def test_half_of_the_spirals_begin_inside_where_corridors_leave_room_to_turn():
    inside = [to_nearest_m(world, world.start) < 0.7 for world in worlds("spiral")]
    assert 0 < sum(inside) < len(inside)
    assert min(to_nearest_m(world, world.start) for world in worlds("spiral")) >= GAP_M / 2 - 1e-9


def test_goals_near_walls_are_as_near_as_promised():
    for world in worlds("near_wall"):
        assert to_nearest_m(world, world.goal) == pytest.approx(GOAL_TO_WALL_M, abs=1e-5)


def test_things_leave_gaps_to_each_other_and_to_the_walls():
    rng = np.random.default_rng(5)
    things = clutter(rng, 9.0, 7.0, 6, 1.0, [(1.0, 3.5), (8.0, 3.5)])
    assert len(things) >= 8
    assert things[:, [0, 2]].min() >= 1.0
    assert things[:, [0, 2]].max() <= 8.0
    assert to_nearest_m(replace(make("slip", 0), static=things), Pose2D(1.0, 3.5)) >= 1.0


def test_people_walk_straight_at_their_pace_and_stand_before_and_after():
    person = Person((1.0, 1.0), (1.0, 4.0), leaves_s=2.0)
    assert person.at(0) == person.at(2_000_000_000) == (1.0, 1.0)
    assert person.at(3_500_000_000) == pytest.approx((1.0, 1.0 + 1.5 * WALK_MPS))
    assert person.at(60_000_000_000) == (1.0, 4.0)


def test_two_people_cross_the_way_about_when_the_robot_may_be_there():
    for world in worlds("people"):
        assert len(world.people) == 2
        for person in world.people:
            x_m = (person.start[0] + person.end[0]) / 2
            crossing_s = person.leaves_s + math.dist(person.start, person.end) / 2 / WALK_MPS
            robot_s = (x_m - world.start.x_m) / 0.5 + 1.0
            assert abs(crossing_s - robot_s) <= 1.5
            assert person.leaves_s > 0
            there = np.array(person.at(round(crossing_s * 1e9)))
            assert there == pytest.approx((x_m, 4.0))
            at_way = world.segments_at(round(crossing_s * 1e9)).reshape(-1, 2) - there
            assert np.hypot(*at_way.T).min() == pytest.approx(PERSON_RADIUS_M, rel=0.04)


def test_odometry_jumps_and_slips_and_scans_are_slow_where_they_should():
    for world in worlds("jump"):
        assert math.hypot(world.jump.x_m, world.jump.y_m) == pytest.approx(JUMP_M)
        assert mazes.spec_of(world).jump_ns > 0
        assert to_nearest_m(world, world.goal) > TURNING_M + JUMP_M
    assert all(mazes.spec_of(world).base.slip_m > 0 for world in worlds("slip"))
    slow, fast = mazes.spec_of(make("slow_scans", 0)), mazes.spec_of(make("slip", 0))
    assert (slow.scan_period_ns, fast.scan_period_ns) == (200_000_000, 26_666_666)


def test_goals_out_of_reach_are_enclosed_or_occupied():
    for world in worlds("occupied"):
        assert world.reasons == (Reason.OCCUPIED,)
        assert HULL.clearance_m(world.goal, bounded(world.static)) == 0
    for world in worlds("enclosed"):
        assert world.reasons == (Reason.ENCLOSED,)
        assert 0 < to_nearest_m(world, world.goal) < 0.9


@pytest.mark.parametrize(
    ("family", "outcome", "reason", "right"),
    [
        ("slip", Outcome.REACHED, "", True),
        ("slip", Outcome.WALKED_INTO, "", False),
        ("slip", Outcome.BLOCKED, Reason.NO_PROGRESS.value, False),
        ("people", Outcome.WALKED_INTO, "", True),
        ("people", Outcome.CONTACT, "", False),
        ("enclosed", Outcome.BLOCKED, Reason.ENCLOSED.value, True),
        ("enclosed", Outcome.BLOCKED, Reason.NO_PROGRESS.value, False),
        ("enclosed", Outcome.TIMEOUT, "", False),
        ("tight_doorway", Outcome.REACHED, "", True),
        ("tight_doorway", Outcome.BLOCKED, Reason.NO_PROGRESS.value, True),
        ("tight_doorway", Outcome.TIMEOUT, "", True),
        ("tight_doorway", Outcome.CONTACT, "", False),
        ("tight_doorway", Outcome.ELSEWHERE, "", False),
    ],
)
def test_a_drive_is_right_if_it_ended_as_it_should(family, outcome, reason, right):
    assert is_right(make(family, 0), run(outcome, reason)) is right


def test_the_table_counts_and_names_what_was_missed():
    runs = [
        {"world": "slip-0", "expected": "reached", "right": True, **run(Outcome.REACHED, time_s=10.0).record()},
        {"world": "slip-1", "expected": "reached", "right": False, **run(Outcome.CONTACT, time_s=3.0).record()},
    ]
    found = row("slip", runs)
    assert (found["worlds"], found["reached"], found["contacts"], found["right"]) == (2, 1, 1, 1)
    assert found["time_median_s"] == 10.0
    assert missed(runs).splitlines() == ["missed in 1 of 2 worlds:", "slip-1: contact after 3 s, expected reached"]
    assert missed(runs[:1]) == "met"


def test_who_gives_a_tight_doorway_up_is_blocked_for_no_right_reason_and_its_time_does_not_count():
    ends = (Outcome.REACHED, "", 10.0), (Outcome.BLOCKED, Reason.NO_PROGRESS.value, 70.0), (Outcome.TIMEOUT, "", 180.0)
    runs = [{"world": "w", "expected": "no contact", "right": True, **run(*end).record()} for end in ends]
    found = row("tight_doorway", runs)
    assert (found["reached"], found["blocked_right"], found["right"], found["time_median_s"]) == (1, 0, 3, 10.0)
    enclosed = {"expected": "goal enclosed", "right": True, **run(Outcome.BLOCKED, "goal enclosed", 5.0).record()}
    assert row("enclosed", [enclosed])["blocked_right"] == 1
    assert row("enclosed", [enclosed])["time_median_s"] == 5.0


def test_a_world_is_driven_and_written_down(tmp_path, capsys):
    assert mazes.main(["--families", "slip", "--limit", "1", "--out", str(tmp_path)]) == 0
    assert "slip" in capsys.readouterr().out
    assert (tmp_path / "mazes_worlds.json").is_file()


def test_a_disc_contains_its_circle():
    middles = disc((1.0, 2.0), 0.25).reshape(-1, 2, 2).mean(axis=1) - (1.0, 2.0)
    np.testing.assert_allclose(np.hypot(*middles.T), 0.25)


def test_other_seeds_are_asked_for_by_the_first(capsys):
    options = ["--families", "tight_doorway", "narrow", "--check", "--first", "1000", "--limit", "1"]
    assert mazes.main(options) == 0
    assert "2 of 2 worlds are as promised" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        mazes.main(["--help"])
    assert "--first 1000" in capsys.readouterr().out
