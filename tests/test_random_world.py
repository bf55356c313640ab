# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds by seed, and places to look at them from."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest

from edgefusion.sim.building import FLOORS, WALLS, wall_parts
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.floor_plan import distances_m
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.mesh import plain
from edgefusion.sim.outline import apart_m, outline_of
from edgefusion.sim.random_world import random_world
from edgefusion.sim.viewpoints import FARTHEST_M, NEAREST_M, ROOM_TO_STAND_M, viewpoint

KINDS = list(CATALOGUE.values())
LASER_HEIGHT_M = 0.35
SEEDS = range(12)


def test_the_same_seed_gives_the_same_world_and_another_one_another() -> None:
    assert random_world(5, KINDS) == random_world(5, KINDS)
    assert random_world(5, KINDS) != random_world(6, KINDS)


def test_worlds_differ_in_place_floor_walls_and_objects() -> None:
    worlds = [random_world(seed, KINDS) for seed in range(60)]
    assert {world.floor for world in worlds} == set(FLOORS)
    assert {wall.finish for world in worlds for wall in world.walls} == set(WALLS)
    assert {world.ceiling_m is None for world in worlds} == {True, False}
    assert {thing.kind.name for world in worlds for thing in world.things} == set(CATALOGUE)


def test_no_object_has_the_seed_or_the_name_of_another() -> None:
    for seed in SEEDS:
        things = random_world(seed, KINDS).things
        assert len({thing.name for thing in things}) == len({thing.seed for thing in things}) == len(things)


@pytest.fixture(scope="module")
def worlds():
    return [build(random_world(seed, KINDS), LASER_HEIGHT_M) for seed in SEEDS]


def test_some_objects_stand_free_and_some_touch(worlds) -> None:
    clearances = [world.plan.clearance_m(i) for world in worlds for i in range(len(world.bodies))]
    assert np.mean([c >= 0.6 for c in clearances]) > 0.25
    assert np.mean([c < 0.1 for c in clearances]) > 0.15


def deepest_m(world: BuiltWorld) -> float:
    """How far the two that overlap most would have to move to touch only; 0 where none do."""
    objects = [outline_of(body) for body in world.bodies]
    walls = [outline_of(wall_parts(wall, plain(0))) for wall in world.world.walls]
    return max(0.0, *(-apart_m(a, b) for a, b in [*combinations(objects, 2), *product(objects, walls)]))


def test_in_most_worlds_nothing_stands_in_anything_else(worlds) -> None:
    assert np.mean([deepest_m(world) < 0.001 for world in worlds]) > 0.8


@pytest.mark.parametrize("seed", [13, 53, 55, 76])
def test_where_two_stand_in_each_other_it_is_less_than_4_cm(seed: int) -> None:
    """The worst of the first hundred worlds."""
    assert 0.005 < deepest_m(build(random_world(seed, KINDS), LASER_HEIGHT_M)) < 0.04


def test_a_viewpoint_is_free_looks_at_an_object_and_repeats(worlds) -> None:
    for seed, world in zip(SEEDS, worlds):
        pose = viewpoint(world, np.random.default_rng(seed))
        assert pose == viewpoint(world, np.random.default_rng(seed))
        assert pose is not None
        assert distances_m([(pose.x_m, pose.y_m)], world.plan.segments).min() > ROOM_TO_STAND_M
        here = np.array([pose.x_m, pose.y_m])
        ahead = []
        for i, thing in enumerate(world.world.things):
            dx, dy = (thing.pose.x_m, thing.pose.y_m) - here
            bearing = np.angle(np.exp(1j * (np.arctan2(dy, dx) - pose.theta)))
            half = max(world.sizes_m[i][:2]) / 2
            ahead.append(abs(bearing) < 0.41 and NEAREST_M < np.hypot(dx, dy) < FARTHEST_M + 2 * half)
        assert any(ahead)


def test_a_world_without_objects_has_no_viewpoint() -> None:
    assert viewpoint(build(random_world(1, KINDS, things=0), LASER_HEIGHT_M), np.random.default_rng(0)) is None
