# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Crops to train the simulator's classifier on: the boxes that the detector proposes in random worlds, imperfect as
they are, each with the name of what it holds and how well it holds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.candidates import Candidate, find_candidates
from edgefusion.perception.motion import laser_motion
from edgefusion.perception.preprocessing import Preprocessing
from edgefusion.sim.built_world import build
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.light import random_light
from edgefusion.sim.random_world import random_world
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.snapshot import Snapshot, snapshot
from edgefusion.sim.viewpoints import viewpoint
from edgefusion.tools.geometry import calibration_of, iou
from edgefusion.types import BACKGROUND, UNKNOWN, Twist2D

OBJECTS = 10
"""Per frame, the nearest first."""

BOXES, BUILDING_BOXES = 5, 1
"""Kept of each object's candidates and of each wall's, by chance: neighbours look alike, walls are everywhere."""

LEAST_SHARE = 0.6
"""Of a cluster's beams that must be one object's, or its name is not clear."""

SPEED_MPS, YAW_RATE_RADPS = 0.5, 0.5
_HEIGHT_JITTER = 0.12


@dataclass(frozen=True)
class Crops:
    """pixels: uint8[n, size, size, 3] RGB. classes: int64[n]. fits: float32[n], the IoU of the box with the object's,
    1 for walls. worlds: int64[n], the seed of each one's world."""

    pixels: npt.NDArray[np.uint8]
    classes: npt.NDArray[np.int64]
    fits: npt.NDArray[np.float32]
    worlds: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.classes)


def class_names() -> list[str]:
    """The labels of the kinds that have one, sorted, and BACKGROUND as the last."""
    return [*sorted({kind.label for kind in CATALOGUE.values()} - {UNKNOWN}), BACKGROUND]


def render_crops(
    worlds: Sequence[int], views: int, heights_m: Sequence[float], preprocessing: Preprocessing
) -> Iterator[Crops]:
    """The crops of one world after the other, each seen from so many places."""
    rig, names = Rig(), class_names()
    calibration = calibration_of(rig)
    kinds = list(CATALOGUE.values())
    with Renderer(rig) as renderer:
        for seed in worlds:
            rng = np.random.default_rng([seed, 1])
            world = build(random_world(seed, kinds), rig.laser_height_m)
            renderer.show(world)
            found = []
            for _ in range(views):
                base = viewpoint(world, rng)
                if base is None:
                    continue
                twist = Twist2D(float(rng.uniform(0, SPEED_MPS)), float(rng.uniform(-YAW_RATE_RADPS, YAW_RATE_RADPS)))
                shot = snapshot(world, renderer, rig, base, twist, random_light(rng), rng)
                found.append(_crops_of(shot, calibration, heights_m, preprocessing, names, seed, rng))
            if found:
                yield joined(found)


def joined(crops: Sequence[Crops]) -> Crops:
    """All of them as one."""
    return Crops(*(np.concatenate([getattr(each, name) for each in crops]) for name in Crops.__dataclass_fields__))


def _crops_of(
    shot: Snapshot,
    calibration: Calibration,
    heights_m: Sequence[float],
    preprocessing: Preprocessing,
    names: Sequence[str],
    seed: int,
    rng: np.random.Generator,
) -> Crops:
    jittered = tuple(float(h) for h in np.asarray(heights_m) * rng.uniform(1 - _HEIGHT_JITTER, 1 + _HEIGHT_JITTER))
    config = PerceptionConfig(heights=jittered, heights_in="metres", objects=OBJECTS)
    T = calibration.T_camera_laser @ laser_motion(shot.motion, calibration.T_base_laser)
    boxes, classes, fits = [], [], []
    for candidate in find_candidates(shot.scan, T, calibration, config):
        labelled = _labelled(shot, candidate, names)
        if labelled is None:
            continue
        kept = BUILDING_BOXES if labelled[2] else BOXES
        for i in rng.permutation(len(candidate.boxes))[:kept]:
            boxes.append(candidate.boxes[i])
            classes.append(labelled[0])
            fits.append(labelled[1][i])
    pixels = preprocessing.apply(shot.frame.image, np.array(boxes, np.int32).reshape(-1, 4))
    return Crops(
        as_pixels(pixels, preprocessing),
        np.array(classes, np.int64),
        np.array(fits, np.float32),
        np.full(len(classes), seed, np.int64),
    )


def _labelled(shot: Snapshot, candidate: Candidate, names: Sequence[str]) -> tuple[int, list[float], bool] | None:
    """The class of a candidate, how well each of its boxes fits, and whether it is a wall; None where that is not
    clear."""
    owners = shot.owners[candidate.cluster.indices]
    owner, count = max(((o, int((owners == o).sum())) for o in set(owners.tolist())), key=lambda each: each[1])
    if count < LEAST_SHARE * len(owners):
        return None
    truth = next((each for each in shot.truth if each.index == owner), None)
    if owner >= 0 and truth is None:  # the camera does not see it
        return None
    if truth is None:
        return names.index(BACKGROUND), [1.0] * len(candidate.boxes), True
    fits = [iou((x0, y0, x1, y1), truth.box) for x0, y0, x1, y1 in candidate.boxes.tolist()]
    return names.index(BACKGROUND if truth.label == UNKNOWN else truth.label), fits, False


def as_pixels(batch: npt.NDArray[np.float32], preprocessing: Preprocessing) -> npt.NDArray[np.uint8]:
    """A normalized batch [n, 3, size, size] as bytes [n, size, size, 3], a quarter of the memory."""
    mean, std = (np.asarray(v, np.float32)[:, None, None] for v in (preprocessing.mean, preprocessing.std))
    return np.asarray(np.clip((batch * std + mean) * 255 + 0.5, 0, 255), np.uint8).transpose(0, 2, 3, 1)
