# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's experiment: across the laboratory, one stop before an oscilloscope at a place that nobody told."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from benchmarks.experiment import HEADER, cells, summary
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.navigation.mission_step import MissionState
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.floor_plan import distances_m
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import SimBase
from edgefusion.sim.simulation import Simulation
from edgefusion.sim.world import World
from edgefusion.sim.world_file import load_world
from edgefusion.tools.arguments import LAB_MODEL
from edgefusion.tools.demo_robot import NEAR_M, DemoRobot, demo_robot
from edgefusion.tools.demo_run import as_fast_as_it_can
from edgefusion.tools.drive import Drive
from edgefusion.tools.experiment import ASIDE_M, LABORATORY, ON_THE_WAY, ROOM_M, placed_by_seed
from edgefusion.tools.vision import LATE_NS, LOOK_NS, Look
from edgefusion.types import Pose2D, Twist2D
from sim_scenes import built, crate, skip_without_renderer

skip_without_renderer()
SEEDS = st.integers(1, 2**31 - 1)


class Driven(NamedTuple):
    world: BuiltWorld
    drive: Drive
    looks: list[Look]


@pytest.fixture(scope="module")
def laboratory() -> World:
    return load_world(LABORATORY)


@pytest.fixture(scope="module")
def robot() -> DemoRobot:
    return demo_robot(LAB_MODEL, ["oscilloscope"])


def driven(robot: DemoRobot, world: World, seed: int = 0) -> Driven:
    """Without what was to be seen in each picture: it takes a third of the time, and only a report tells of it."""
    with Renderer(robot.rig) as renderer, pytest.MonkeyPatch.context() as patch:
        patch.setattr(Simulation, "truth", lambda *_: [])
        surfaces = build(world, robot.rig.laser_height_m)
        drive = robot.drive(surfaces, renderer, seed, as_fast_as_it_can)
        return Driven(surfaces, drive, list(drive))


@pytest.fixture(scope="module")
def experiment(robot: DemoRobot, laboratory: World) -> Driven:
    """As `make demo` drives it."""
    return driven(robot, laboratory)


def test_it_arrives_and_touches_nothing(experiment: Driven) -> None:
    drive = experiment.drive
    assert (drive.state, drive.reason) == (MissionState.ARRIVED, "")
    off = drive.log.trail[-1].believed.relative_to(Pose2D(5, 5.5, math.radians(15)))
    assert math.hypot(off.x_m, off.y_m) < 0.05 and abs(off.theta) < math.radians(3)
    assert 0 < drive.clearance_m < 1


def test_it_inspects_the_oscilloscope_on_the_way_once(experiment: Driven) -> None:
    (result,) = experiment.drive.log.inspections
    assert (result.label, result.reason, result.note) == ("oscilloscope", "", "")
    assert experiment.drive.pictured == {result.id: ON_THE_WAY}
    assert result.detection.distance_m < NEAR_M
    index = next(i for i, thing in enumerate(experiment.world.world.things) if thing.name == ON_THE_WAY)
    assert experiment.world.plan.nearest_m(index, result.place_m) < 0.15


def test_it_stands_still_for_ten_seconds_and_faces_the_object(experiment: Driven) -> None:
    (result,) = experiment.drive.log.inspections
    assert result.stood_ns is not None
    assert result.ended_ns - result.stood_ns == pytest.approx(10e9, abs=0.1e9)
    stood = [each.pose for each in experiment.drive.log.trail if result.stood_ns <= each.stamp_ns <= result.ended_ns]
    # At rest means slower than can be told from noise, not without any motion.
    assert max(math.hypot(pose.x_m - stood[-1].x_m, pose.y_m - stood[-1].y_m) for pose in stood) < 0.005
    x_m, y_m = result.place_m
    bearing = math.atan2(y_m - result.pose.y_m, x_m - result.pose.x_m) - result.pose.theta
    assert abs(math.remainder(bearing, 2 * math.pi)) < math.radians(6)


def test_while_it_stands_it_looks_no_more_than_it_needs_to(experiment: Driven) -> None:
    (result,) = experiment.drive.log.inspections
    assert result.stood_ns is not None
    stamps = [look.shot.frame.stamp_ns for look in experiment.looks]
    stood = [stamp_ns for stamp_ns in stamps if result.stood_ns <= stamp_ns < result.ended_ns]
    assert 10 <= len(stood) <= 15
    on_the_way = np.diff([stamp_ns for stamp_ns in stamps if stamp_ns < result.begun_ns])
    assert (on_the_way >= LOOK_NS).all() and (on_the_way < LOOK_NS + 0.1e9).all()


def test_the_picture_is_of_the_time_after_it_was_asked_for(experiment: Driven) -> None:
    (result,) = experiment.drive.log.inspections
    assert result.picture is not None and result.stood_ns is not None
    assert result.stood_ns <= result.picture.stamp_ns < result.stood_ns + 0.2e9
    assert result.picture.image.shape == (480, 640, 3)


def test_nothing_is_known_of_an_object_before_its_frame_is_old_enough(experiment: Driven) -> None:
    (result,) = experiment.drive.log.inspections
    named = [
        look.shot.frame.stamp_ns
        for look in experiment.looks
        if any(each.label == "oscilloscope" and each.distance_m <= NEAR_M for each in look.detections)
    ]
    assert result.begun_ns >= sorted(named)[2] + LATE_NS


def test_a_contact_ends_the_drive(robot: DemoRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is commanded, the base drives ahead, into a crate."""
    command = SimBase.command
    monkeypatch.setattr(SimBase, "command", lambda self, twist: command(self, Twist2D(0.6, 0)))
    scene = replace(built([crate("crate", 1.5, 0, (0.5, 1.0, 0.6))]).world, goal=Pose2D(4, 0))
    drive = driven(robot, scene).drive
    assert (drive.state, drive.reason, drive.clearance_m) == (MissionState.STOPPED, "contact", 0)
    assert drive.log.trail[-1].pose.x_m == pytest.approx(1.25 - 0.21, abs=0.05)


def test_seed_0_leaves_the_oscilloscope_where_the_world_has_it(laboratory: World) -> None:
    assert placed_by_seed(laboratory, 0) == laboratory


@settings(max_examples=5)
@given(seed=SEEDS)
def test_wherever_a_seed_places_it_the_robot_gets_around_it_on_the_straight_way(laboratory: World, seed: int) -> None:
    there = build(placed_by_seed(laboratory, seed), Rig().laser_height_m)
    index = next(i for i, thing in enumerate(there.world.things) if thing.name == ON_THE_WAY)
    start, goal, scope = there.world.start, there.world.goal, there.world.things[index].pose
    assert there.plan.clearance_m(index) >= ROOM_M - 1e-6
    assert min(there.plan.nearest_m(index, (pose.x_m, pose.y_m)) for pose in (start, goal)) >= ROOM_M - 1e-6
    way = np.array([(start.x_m, start.y_m, goal.x_m, goal.y_m)])
    assert distances_m([(scope.x_m, scope.y_m)], way)[0, 0] <= ASIDE_M + 1e-9


def test_all_else_stays_where_it_is(laboratory: World) -> None:
    moved, there = (
        [thing for thing in world.things if thing.name != ON_THE_WAY]
        for world in (placed_by_seed(laboratory, 1), laboratory)
    )
    assert moved == there


def test_seeds_differ_and_the_same_seed_gives_the_same_world(laboratory: World) -> None:
    worlds = [placed_by_seed(laboratory, seed) for seed in (1, 2, 1)]
    assert worlds[0] == worlds[2] != worlds[1]


def test_a_world_without_it_is_refused(laboratory: World) -> None:
    with pytest.raises(RefusedError, match=r"world 'office': expected an object named 'oscilloscope on the way'"):
        placed_by_seed(load_world("office"), 1)


def test_a_world_without_room_for_it_is_refused(laboratory: World) -> None:
    near = replace(laboratory, goal=Pose2D(0.5, 0.5, 0))
    with pytest.raises(RefusedError, match="world 'laboratory': no room for 'oscilloscope on the way' near the way"):
        placed_by_seed(near, 1)


def test_the_benchmarks_table_counts_what_went_as_it_should() -> None:
    run = {
        "arrived": True, "pictures": 1, "others": 0, "clearance_m": 0.5, "duration_s": 30.0, "odometry_error_m": 0.02,
        "odometry_error_deg": 2.0, "true_error_m": 0.1, "true_error_deg": 3.0,
    }  # fmt: skip
    crash = {**run, "arrived": False, "pictures": 0, "others": 1, "clearance_m": 0.0, "true_error_m": 5.0}
    row = summary([run, {**run, "odometry_error_m": 0.04}, run, crash])
    assert (row["drives"], row["arrived"], row["pictures"], row["others"], row["contacts"]) == (4, 3, 3, 1, 1)
    assert row["odometry_error_m"] == (0.02, 0.04) and row["true_error_m"] == (0.1, 0.1)
    assert row["clearance_m"] == (0.5, 0.0)
    assert cells(row)[5:] == [
        "2.0 / 4.0 cm, 2.0 / 2.0 deg", "10.0 / 10.0 cm, 3.0 / 3.0 deg", "30.0 / 30.0 s", "50 / 0 cm",
    ]  # fmt: skip
    assert len(cells(row)) == len(HEADER) == len(cells(summary([crash])))
