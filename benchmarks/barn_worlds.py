# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds of the BARN layout: cylinders between a start and a goal, one .npz with an index beside it.

The .npz holds centres_<world> float[n, 2] [m] for every world that the index names.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Mapping, Tuple
from zipfile import BadZipFile

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Pose2D

Floats = npt.NDArray[np.float64]
Point = Tuple[float, float]

SIDES = 12
"""Of the polygon about a cylinder: never inside it, and at most 3.5 % of the radius outside."""


class Entry(msgspec.Struct, frozen=True):
    """A world of the index. path_length: of the shortest way [m], which the score is about."""

    world: int
    path_length: float


class Index(msgspec.Struct, frozen=True):
    """What the index says: metres, seconds, radians; footprint about base_link."""

    radius: float
    start: Tuple[float, float, float]
    goal: Point
    goal_tolerance: float
    timeout: float
    footprint: Tuple[Point, ...]
    worlds: Tuple[Entry, ...]


@dataclass(frozen=True)
class BarnWorld:
    """number: its name in the files. centres_m: of the cylinders, float64[n, 2]."""

    number: int
    path_length_m: float
    centres_m: Floats

    def segments(self, radius_m: float) -> Floats:
        """The cylinders as polygons of SIDES about them: [n * SIDES, 4]."""
        angles = 2 * math.pi / SIDES * np.arange(SIDES)
        corners = radius_m / math.cos(math.pi / SIDES) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        outlines = self.centres_m[:, None] + corners
        return np.concatenate([outlines, np.roll(outlines, -1, axis=1)], axis=2).reshape(-1, 4)


def score(success: bool, path_length_m: float, time_s: float) -> float:
    """BARN's: success * OT / clip(AT, 2 OT, 8 OT), where OT is the time for the shortest way at 2 m/s; 0.5 at most."""
    optimal_s = path_length_m / 2
    return optimal_s / min(max(time_s, 2 * optimal_s), 8 * optimal_s) if success else 0.0


def goal_in_odom(index: Index) -> Pose2D:
    """The goal as seen from the start, where odometry begins."""
    return Pose2D(*index.goal, index.start[2]).relative_to(Pose2D(*index.start))


def read_worlds(worlds: Path, index: Path) -> Tuple[Index, List[BarnWorld]]:
    """The index, and the worlds that it names. Raises RefusedError for files of another layout."""
    named = _read_index(index)
    try:
        with worlds.open("rb") as file:
            arrays = np.load(file, allow_pickle=False)
            centres = {name: arrays[name] for name in arrays.files}
    except OSError as error:
        raise RefusedError(f"{worlds}: cannot be read: {error.strerror or error}") from error
    except (ValueError, AttributeError, BadZipFile) as error:  # numpy gives a lone array without files
        raise RefusedError(f"{worlds}: expected an .npz of plain arrays: {error}") from error
    return named, [_world(entry, centres, worlds) for entry in named.worlds]


def _read_index(path: Path) -> Index:
    try:
        index = msgspec.json.decode(path.read_bytes(), type=Index)
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:  # also msgspec.ValidationError
        raise RefusedError(f"{path}: {error}") from error
    for name in ("radius", "goal_tolerance", "timeout"):
        if not getattr(index, name) > 0:
            raise RefusedError(f"{path}: {name}: expected more than 0, got {getattr(index, name)}")
    if not index.worlds or min(entry.path_length for entry in index.worlds) <= 0:
        raise RefusedError(f"{path}: worlds: expected at least one, each with a path_length above 0")
    return index


def _world(entry: Entry, centres: Mapping[str, npt.NDArray[np.generic]], path: Path) -> BarnWorld:
    name = f"centres_{entry.world}"
    if name not in centres:
        raise RefusedError(f"{path}: expected an array {name}, got {len(centres)} others")
    found = centres[name]
    if found.dtype.kind not in "fiu" or found.ndim != 2 or found.shape[1] != 2:
        raise RefusedError(f"{path}: {name}: expected numbers [n, 2], got {found.dtype} {list(found.shape)}")
    centres_m = found.astype(float)
    if not np.isfinite(centres_m).all():
        raise RefusedError(f"{path}: {name}: expected finite numbers")
    return BarnWorld(entry.world, entry.path_length, centres_m)
