# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The worlds that ship: they load, between them they hold every kind, and one can drive through them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.floor_plan import distances_m
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import SimBase
from edgefusion.sim.route import RouteFollower
from edgefusion.sim.world import World
from edgefusion.sim.world_check import ROBOT_RADIUS_M
from edgefusion.sim.world_file import load_world, world_names
from edgefusion.types import Pose2D

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
    """Where a base comes along on its route, five minutes at most."""
    world = built.world
    base, follower = SimBase(pose=world.start), RouteFollower(world.route, world.goal)
    poses = [base.pose]
    while not follower.arrived and len(poses) < 6000:
        base.command(follower.step(base.pose))
        base.step(STEP_NS)
        poses.append(base.pose)
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


def test_a_base_arrives_on_its_route_and_keeps_clear_of_everything(built: BuiltWorld, driven: list[Pose2D]) -> None:
    arrived = driven[-1].relative_to(built.world.goal)
    assert math.hypot(arrived.x_m, arrived.y_m) < 0.1 and abs(arrived.theta) < math.radians(3)
    assert distances_m([(pose.x_m, pose.y_m) for pose in driven], built.plan.segments).min() > ROBOT_RADIUS_M


def test_on_its_route_a_base_passes_before_three_objects_of_four(built: BuiltWorld, driven: list[Pose2D]) -> None:
    world = built.world
    seen = [any(straight_ahead(pose, world, index) for pose in driven) for index in range(len(world.things))]
    assert sum(seen) >= 0.75 * len(seen)


def test_objects_look_at_the_side_that_one_sees_them_from(built: BuiltWorld, driven: list[Pose2D]) -> None:
    for index, thing in enumerate(built.world.things):
        seen_from = [pose.relative_to(thing.pose) for pose in driven if straight_ahead(pose, built.world, index)]
        if seen_from:
            assert min(abs(math.atan2(each.y_m, each.x_m)) for each in seen_from) < math.radians(60), thing.name
