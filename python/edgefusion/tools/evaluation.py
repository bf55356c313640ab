# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Random and shipped worlds through the detector, with several settings on the same frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Iterator, Sequence

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.detector import Detector
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.light import random_light
from edgefusion.sim.random_world import random_world
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.snapshot import Snapshot, snapshot
from edgefusion.sim.viewpoints import viewpoint
from edgefusion.sim.world import World
from edgefusion.sim.world_file import load_world
from edgefusion.tools.measure import Claim, Seen, compare
from edgefusion.types import Detection, Twist2D

RANDOM = "random"
"""The name that stands for random worlds, a new one every VIEWS frames."""

FIRST_SEED = 2_000_000
"""Of the random worlds; models/train_lab.py trains and measures below."""

VIEWS, PATIENCE = 5, 10
"""Frames of a world, and how many worlds in a row may have nothing to look at."""

SPEED_MPS, YAW_RATE_RADPS = 0.5, 0.5


@dataclass
class Outcome:
    """What one setting made of all frames."""

    seen: list[Seen] = field(default_factory=list)
    claims: list[Claim] = field(default_factory=list)


@dataclass(frozen=True)
class Look:
    """One frame of a world. number: of the frame in the run."""

    world: BuiltWorld
    shot: Snapshot
    number: int


Watcher = Callable[[str, Look, Sequence[Detection], Sequence[Seen]], None]
"""Is shown every setting's answer to every frame, to keep pictures of."""


def named_worlds(names: Sequence[str]) -> list[World | None]:
    """The worlds of these names or files, None for RANDOM. Raises RefusedError for one that is not there."""
    return [None if name == RANDOM else load_world(name) for name in names]


def looks(given: Sequence[World | None], frames: int, seed: int, rig: Rig, renderer: Renderer) -> Iterator[Look]:
    """So many frames, dealt to the worlds in turn, a new random one for each None.

    Raises RefusedError where a round of all of them has no place to see an object from.
    """
    worlds = _in_turn(given, seed)
    number, empty = 0, 0
    while number < frames:
        if empty > max(len(given), PATIENCE):
            raise RefusedError("worlds: expected an object that can be looked at from 0.5 to 5 m, got none")
        turn, world = next(worlds)
        rng = np.random.default_rng([FIRST_SEED + seed, turn])
        built = build(world, rig.laser_height_m)
        renderer.show(built)
        empty += 1
        for _ in range(min(VIEWS, frames - number)):
            base = viewpoint(built, rng)
            if base is None:
                break
            empty = 0
            twist = Twist2D(float(rng.uniform(0, SPEED_MPS)), float(rng.uniform(-YAW_RATE_RADPS, YAW_RATE_RADPS)))
            yield Look(built, snapshot(built, renderer, rig, base, twist, random_light(rng), rng), number)
            number += 1


def _in_turn(given: Sequence[World | None], seed: int) -> Iterator[tuple[int, World]]:
    turn, kinds = 0, list(CATALOGUE.values())
    while True:
        for world in given:
            yield turn, world or random_world(FIRST_SEED + 10_000 * seed + turn, kinds)
            turn += 1


def evaluate(
    looks: Iterator[Look], detectors: dict[str, Detector], calibration: Calibration, watch: Watcher
) -> dict[str, Outcome]:
    """Every look through every detector."""
    outcomes = {name: Outcome() for name in detectors}
    for look in looks:
        plan = look.world.plan
        clearances_m = [plan.clearance_m(index) for index in range(len(look.world.bodies))]
        for name, detector in detectors.items():
            detections = detector.detect(look.shot.scan, look.shot.frame, look.shot.motion)
            seen, claims = compare(look.shot, detections, calibration, clearances_m, look.world.world.name, look.number)
            outcomes[name].seen += seen
            outcomes[name].claims += claims
            watch(name, look, detections, seen)
    return outcomes
