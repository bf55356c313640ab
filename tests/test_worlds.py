# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The worlds that ship: they load, between them they hold every kind, and one can drive through them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.config import Config
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.progress import State
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.floor_plan import distances_m
from edgefusion.sim.hull import Hull, bounded
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.plan_simulation import PlanSimulation, PlanSpec
from edgefusion.sim.rig import Rig
from edgefusion.sim.world import World
from edgefusion.sim.world_file import load_world, world_names
from edgefusion.types import Goal, Pose2D

RIG = Rig()
STEP_NS = 50_000_000
SEEN_WITHIN = math.radians(30)
"""Off the camera's axis; its picture ends at 35 degrees."""


@pytest.fixture(scope="module")
def worlds() -> dict[str, World]:
    return {name: load_world(name) for name in world_names()}


@pytest.fixture(scope="module", params=world_names())
def built(request: pytest.FixtureRequest, worlds: dict[str, World]) -> BuiltWorld:
    return build(worlds[request.param], RIG.laser_height_m)


@pytest.fixture(scope="module")
def driven(built: BuiltWorld) -> list[Pose2D]:
    """Where a robot comes along that finds its way from start to goal, two minutes at most."""
    world, config = built.world, Config()
    delay_ns = round(config.base.command_delay_s * 1e9)
    spec = PlanSpec(config.base.footprint_m, laser_pose=Pose2D(*config.base.laser_pose), command_delay_ns=delay_ns)
    sim, navigator = PlanSimulation(built.plan.segments, world.start, spec), Navigator(config.navigation, config.base)
    goal, state = Goal("goal", world.goal.relative_to(world.start)), State.DRIVING
    poses = [sim.pose]
    while state in (State.DRIVING, State.TURNING) and len(poses) < 2400:
        twist, progress = navigator.step(sim.stamp_ns, sim.newest_scan(), sim.odometry, goal)
        sim.command(twist)
        sim.step_to(sim.stamp_ns + STEP_NS)
        state = progress.state
        poses.append(sim.pose)
    return poses


def straight_ahead(pose: Pose2D, world: World, index: int) -> bool:
    """Whether a thing is before the camera, from half a metre to five."""
    seen = world.things[index].pose.relative_to(pose)
    return 0.5 < math.hypot(seen.x_m, seen.y_m) < 5.0 and abs(math.atan2(seen.y_m, seen.x_m)) < SEEN_WITHIN


def test_the_four_worlds_ship() -> None:
    assert world_names() == ["laboratory", "office", "storeroom", "street"]


def test_a_world_is_called_as_its_file_and_says_what_it_is(worlds: dict[str, World]) -> None:
    for name, world in worlds.items():
        assert world.name == name
        assert world.description


def test_every_kind_stands_in_some_world(worlds: dict[str, World]) -> None:
    used = {thing.kind.name for world in worlds.values() for thing in world.things}
    assert used == set(CATALOGUE)


def test_the_laboratory_is_the_papers_experiment(worlds: dict[str, World]) -> None:
    world = worlds["laboratory"]
    assert world.start == Pose2D()
    assert world.goal == Pose2D(5.0, 5.5, math.radians(15))
    assert "oscilloscope" in {thing.kind.name for thing in world.things}


def test_the_oscilloscope_stands_on_the_straight_way_to_the_papers_goal(worlds: dict[str, World]) -> None:
    world = worlds["laboratory"]
    (scope,) = (thing for thing in world.things if thing.name == "oscilloscope on the way")
    way = [(world.start.x_m, world.start.y_m, world.goal.x_m, world.goal.y_m)]
    assert distances_m([(scope.pose.x_m, scope.pose.y_m)], np.array(way)).min() < 0.1


def test_only_the_street_is_under_the_sky(worlds: dict[str, World]) -> None:
    assert [name for name, world in worlds.items() if world.ceiling_m is None] == ["street"]


def test_a_world_has_ten_to_twenty_objects(built: BuiltWorld) -> None:
    assert 10 <= len(built.world.things) <= 20


def test_the_laser_meets_every_object(built: BuiltWorld) -> None:
    assert all(len(built.plan.of(index)) for index in range(len(built.bodies)))


def test_a_robot_finds_its_way_to_the_goal_and_touches_nothing(built: BuiltWorld, driven: list[Pose2D]) -> None:
    arrived = driven[-1].relative_to(built.world.goal)
    assert math.hypot(arrived.x_m, arrived.y_m) < 0.06 and abs(arrived.theta) < math.radians(3.5)
    hull, plan = Hull(Config().base.footprint_m), bounded(built.plan.segments)
    assert min(hull.clearance_m(pose, plan) for pose in driven) > 0


def test_on_its_way_a_robot_passes_before_every_second_object(built: BuiltWorld, driven: list[Pose2D]) -> None:
    world = built.world
    seen = [any(straight_ahead(pose, world, index) for pose in driven) for index in range(len(world.things))]
    assert sum(seen) >= 0.5 * len(seen)


def test_three_of_four_objects_look_at_the_side_that_one_sees_them_from(
    built: BuiltWorld, driven: list[Pose2D]
) -> None:
    turned = []
    for index, thing in enumerate(built.world.things):
        seen_from = [pose.relative_to(thing.pose) for pose in driven if straight_ahead(pose, built.world, index)]
        if seen_from:
            turned.append(min(abs(math.atan2(each.y_m, each.x_m)) for each in seen_from))
    assert sum(angle < math.radians(60) for angle in turned) >= 0.75 * len(turned)
