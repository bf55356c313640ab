# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Walls, floors, ceilings: where they are, and what they are made of, by the world's seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from edgefusion.sim.building import FLOORS, TILE_M, WALLS, Finish, building_parts, sky, wall_parts
from edgefusion.sim.mesh import plain
from edgefusion.sim.world import Wall, World
from edgefusion.types import Pose2D

WALL = Wall((1.0, 2.0), (4.0, 6.0), 2.5, 0.2, "facade")
WORLD = World("w", 5, "tiles", 2.5, (WALL,), (), Pose2D(), Pose2D())
FINISHES = {f"wall of {name}": finish for name, finish in WALLS.items()}
FINISHES.update({f"floor of {name}": finish for name, finish in FLOORS.items()})
EVEN = ["wall of plaster", "wall of concrete", "floor of linoleum", "floor of asphalt"]


def made(finish: Finish, seed: int) -> np.ndarray:
    return finish(np.random.default_rng(seed))


def bytes_of(world: World) -> list[bytes]:
    return [array.tobytes() for part in building_parts(world) for array in (part.vertices, part.uv, part.texture)]


@pytest.mark.parametrize("name", sorted(FINISHES))
def test_a_finish_is_the_same_by_the_same_seed_and_another_by_another(name: str) -> None:
    tile = made(FINISHES[name], 1)
    assert tile.dtype == np.uint8 and tile.ndim == 3
    np.testing.assert_array_equal(made(FINISHES[name], 1), tile)
    assert (made(FINISHES[name], 2) != tile).any()


@pytest.mark.parametrize("name", EVEN)
def test_even_finishes_have_no_seam_where_a_tile_meets_itself(name: str) -> None:
    tile = made(FINISHES[name], 3).astype(float).mean(axis=2)
    for axis in (0, 1):
        steps = np.abs(np.diff(tile, axis=axis, append=tile.take([0], axis=axis))).mean(axis=1 - axis)
        assert steps[-1] < 1.5 * steps[:-1].mean()


def test_a_world_of_the_same_seed_is_built_alike() -> None:
    assert bytes_of(WORLD) == bytes_of(WORLD) != bytes_of(replace(WORLD, seed=6))


def test_a_wall_is_as_long_high_and_thick_as_it_says() -> None:
    faces = wall_parts(WALL, plain(0))[:4]
    corners = np.concatenate([face.vertices for face in faces]).astype(float)
    along, across = np.array([0.6, 0.8, 0]), np.array([-0.8, 0.6, 0])
    extents = [np.ptp(corners @ axis) for axis in (along, across, np.array([0, 0, 1]))]
    np.testing.assert_allclose(extents, (5.0, 0.2, 2.5), atol=1e-6)
    np.testing.assert_allclose(corners.mean(axis=0), (2.5, 4.0, 1.25), atol=1e-6)


def test_the_faces_of_a_wall_look_outwards() -> None:
    for face in wall_parts(WALL, plain(0)):
        outward = face.vertices.mean(axis=0).astype(float) - (2.5, 4.0, 0)
        a, b, c = face.vertices[face.triangles[0]].astype(float)
        assert face.normals[0] @ outward > 0
        assert np.cross(b - a, c - a) @ face.normals[0] > 0


def test_a_tile_is_repeated_at_its_own_size() -> None:
    uv = wall_parts(WALL, plain(0))[0].uv
    np.testing.assert_allclose(np.ptp(uv, axis=0) * TILE_M, (5.0, 2.5))


def test_the_floor_is_level_and_reaches_beyond_all_walls() -> None:
    floor = building_parts(WORLD)[0]
    assert (floor.vertices[:, 2] == 0).all()
    assert (floor.vertices[:, :2].min(axis=0) < (-10, -9)).all()
    assert (floor.vertices[:, :2].max(axis=0) > (15, 17)).all()


def test_there_is_a_ceiling_at_its_height_or_none() -> None:
    assert (building_parts(WORLD)[-1].vertices[:, 2] == 2.5).all()
    assert len(building_parts(replace(WORLD, ceiling_m=None))) == len(building_parts(WORLD)) - 1


def test_the_sky_is_bluer_the_higher_it_is() -> None:
    picture = sky(8, 100, 60.0).astype(int)
    assert picture.shape == (100, 8, 3)
    blue_over_red = picture[:, 0, 0] - picture[:, 0, 2]
    assert (np.diff(blue_over_red) <= 0).all()
    assert blue_over_red[0] > blue_over_red[60] + 50
