# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds as small TOML files, read strictly and checked for sense. In a file angles are degrees."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Iterable, List, Literal, Mapping, Optional, Tuple

import msgspec
import numpy as np

from edgefusion.config import convert, read_toml
from edgefusion.errors import RefusedError
from edgefusion.sim.building import FLOORS, WALLS
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.renderer import MOST_THINGS
from edgefusion.sim.world import Thing, Wall, World
from edgefusion.sim.world_check import check_world
from edgefusion.types import Pose2D

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

FOLDER = Path(__file__).resolve().parents[1] / "data" / "worlds"

# Every number has limits: without them, infinity and typing errors get in.
_At = Annotated[float, msgspec.Meta(ge=-100, le=100)]
_Degrees = Annotated[float, msgspec.Meta(ge=-360, le=360)]
_Side = Annotated[float, msgspec.Meta(ge=0.01, le=20)]
_Height = Annotated[float, msgspec.Meta(ge=0.1, le=30)]
_Thickness = Annotated[float, msgspec.Meta(ge=0.01, le=5)]
_Seed = Annotated[int, msgspec.Meta(ge=0, lt=2**31)]
_Name = Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
_Pose = Tuple[_At, _At, _Degrees]
_Corner = Tuple[_At, _At]


class WallEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A polyline of straight walls."""

    points: Annotated[List[_Corner], msgspec.Meta(min_length=2, max_length=100)]
    height_m: _Height
    thickness_m: _Thickness
    finish: str


class ObjectEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """pose: its middle on the ground and where its front looks. Without a size it is as its kind is built, without a
    name its kind and number, without a seed one that follows from the world's."""

    kind: str
    pose: _Pose
    size: Optional[Tuple[_Side, _Side, _Side]] = None
    name: Optional[_Name] = None
    seed: Optional[_Seed] = None


class WorldFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """NAME.toml. Without a ceiling the sky is seen."""

    version: Literal[1]
    name: _Name
    description: str
    seed: _Seed
    floor: str
    ceiling_m: Optional[_Height] = None
    start: _Pose
    goal: _Pose
    walls: Annotated[List[WallEntry], msgspec.Meta(max_length=200)] = []
    objects: Annotated[List[ObjectEntry], msgspec.Meta(max_length=MOST_THINGS)] = []


def world_names() -> list[str]:
    """The names of the worlds that ship with edgefusion."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def load_world(name_or_path: str | Path) -> World:
    """A world that ships, by its name, or that of a .toml file. Raises RefusedError, one line."""
    path = _path(name_or_path)
    content = convert(read_toml(path), WorldFile, path)
    try:
        world = _world(content)
        check_world(world)
    except RefusedError as error:
        raise RefusedError(f"{path}: {error}") from error
    return world


def _path(name_or_path: str | Path) -> Path:
    if Path(name_or_path).suffix == ".toml":
        return Path(name_or_path)
    names = world_names()
    if str(name_or_path) not in names:
        raise RefusedError(f"world: expected a .toml file or one of {', '.join(names)}, got {str(name_or_path)!r}")
    return FOLDER / f"{name_or_path}.toml"


def _world(content: WorldFile) -> World:
    return World(
        name=content.name,
        seed=content.seed,
        floor=_one_of(FLOORS, "floor", content.floor),
        ceiling_m=content.ceiling_m,
        walls=tuple(wall for i, entry in enumerate(content.walls) for wall in _walls(i, entry)),
        things=tuple(_things(content)),
        start=_pose(content.start),
        goal=_pose(content.goal),
        description=content.description,
    )


def _walls(index: int, entry: WallEntry) -> list[Wall]:
    where = f"walls[{index}]"
    finish = _one_of(WALLS, f"{where}.finish", entry.finish)
    for a, b in zip(entry.points, entry.points[1:]):
        if a == b:
            raise RefusedError(f"{where}.points: expected neighbours that differ, got {list(a)} twice")
    return [Wall(a, b, entry.height_m, entry.thickness_m, finish) for a, b in zip(entry.points, entry.points[1:])]


def _things(content: WorldFile) -> Iterable[Thing]:
    kinds = [_one_of(CATALOGUE, f"objects[{i}].kind", entry.kind) for i, entry in enumerate(content.objects)]
    for i, entry in enumerate(content.objects):
        yield Thing(
            name=entry.name or f"{entry.kind} {kinds[: i + 1].count(entry.kind)}",
            kind=CATALOGUE[entry.kind],
            pose=_pose(entry.pose),
            seed=_seed(content.seed, i) if entry.seed is None else entry.seed,
            size_m=entry.size,
        )


def _seed(world_seed: int, index: int) -> int:
    return int(np.random.default_rng([world_seed, index]).integers(2**31))


def _pose(values: tuple[float, float, float]) -> Pose2D:
    return Pose2D(values[0], values[1], math.radians(values[2]))


def _one_of(known: Mapping[str, object], what: str, name: str) -> str:
    if name not in known:
        raise RefusedError(f"{what}: expected one of {', '.join(sorted(known))}, got {name!r}")
    return name
