# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is really there: for every object that both sensors see, its label, its box, its distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.lens import SUPERSAMPLING
from edgefusion.sim.renderer import Mask, Renderer
from edgefusion.sim.rig import Rig
from edgefusion.types import Box, Pose2D

LEAST_PX = 12
"""Objects of which fewer pixels show are not seen."""


@dataclass(frozen=True)
class ObjectTruth:
    """One object in one frame; a support belongs to its object (kinds/kind.py).

    index: the thing's in the world. box: of what shows of it, in the image [px]. full_box: of all of it that would be
    in the image if nothing stood before it. range_m: from the laser's origin to its nearest surface in the scan plane,
    at the frame's stamp. occlusion: share of its pixels in the image that something else hides. beams: how
    many of the scan's hit it, dropped ones included.
    """

    index: int
    name: str
    kind: str
    label: str
    box: Box
    full_box: Box
    range_m: float
    occlusion: float
    beams: int


def truth_of(
    world: BuiltWorld, renderer: Renderer, rig: Rig, base: Pose2D, hits: npt.NDArray[np.int32]
) -> list[ObjectTruth]:
    """The objects that the camera sees from `base` and the scan hit, nearest first.

    hits: the row of world.plan that each beam met, -1 for none; the renderer shows this world.
    """
    owners = world.plan.owners[hits[hits >= 0]]
    beams = np.bincount(owners[owners >= 0], minlength=len(world.bodies))
    mask = renderer.mask(base)
    laser = rig.laser_pose(base)
    found = []
    for index in np.unique(mask[mask >= 0]).tolist():
        shows = mask == index
        if not beams[index] or np.count_nonzero(shows) < LEAST_PX * SUPERSAMPLING**2:
            continue
        thing, alone = world.world.things[index], renderer.mask_alone(base, index)
        found.append(
            ObjectTruth(
                index=index,
                name=thing.name,
                kind=thing.kind.name,
                label=thing.kind.label,
                box=box_of(shows),
                full_box=box_of(alone),
                range_m=world.plan.nearest_m(index, (laser.x_m, laser.y_m)),
                occlusion=float(1 - np.count_nonzero(shows & alone) / np.count_nonzero(alone)),
                beams=int(beams[index]),
            )
        )
    return sorted(found, key=lambda each: each.range_m)


def box_of(mask: Mask | npt.NDArray[np.bool_]) -> Box:
    """The image's box around what is set in a mask of SUPERSAMPLING times the image's size."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    x0, x1, y0, y1 = columns[0], columns[-1] + 1, rows[0], rows[-1] + 1
    # Rounded inwards: the rasterizer draws the pixels at both ends of an edge, a quarter of the image's too many.
    half = SUPERSAMPLING // 2
    x0, y0 = (x0 + half) // SUPERSAMPLING, (y0 + half) // SUPERSAMPLING
    return int(x0), int(y0), int(max(x1 // SUPERSAMPLING, x0 + 1)), int(max(y1 // SUPERSAMPLING, y0 + 1))
