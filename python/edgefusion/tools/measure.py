# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One frame's detections beside the truth: which object each one is, and how far off."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np
import numpy.typing as npt

from edgefusion._core import project
from edgefusion.perception.calibration import Calibration
from edgefusion.sim.snapshot import Snapshot
from edgefusion.sim.truth import ObjectTruth
from edgefusion.tools.geometry import iou
from edgefusion.types import UNKNOWN, Detection, Scan

RANGE_M = (0.5, 5.0)
LEAST_BEAMS = 5
LEAST_IN_VIEW = 0.5
"""Share of an object's beams that must fall into the image, or it is not in view."""

MOST_OCCLUDED = 0.02
FREE_M, TOUCHING_M = 0.6, 0.1
"""From anything else: twice DBSCAN's eps and more is free-standing; what is nearer than the other touches."""


@dataclass(frozen=True)
class Seen:
    """An object that both sensors saw, and what came of it. The errors are None where it was not found.

    beams: those that hit it and fall into the image; in_view: their share of all that hit it. clearance_m: to the
    nearest other thing. named: its label is right, UNKNOWN for one without a name. height_error: relative.
    """

    world: str
    frame: int
    kind: str
    label: str
    range_m: float
    beams: int
    in_view: float
    occlusion: float
    clearance_m: float
    found: bool
    said: str = ""
    named: bool = False
    iou: float | None = None
    height_error: float | None = None
    width_error_px: float | None = None
    distance_error_m: float | None = None
    sigma_m: float | None = None

    @property
    def counts(self) -> bool:
        """Whether it is one of those that the aims are about, free-standing or not."""
        least, most = RANGE_M
        seen = self.in_view >= LEAST_IN_VIEW and self.occlusion <= MOST_OCCLUDED
        return seen and least <= self.range_m <= most and self.beams >= LEAST_BEAMS

    @property
    def free(self) -> bool:
        """Whether nothing is near it."""
        return self.counts and self.clearance_m >= FREE_M

    @property
    def touching(self) -> bool:
        """Whether it touches a wall or another object."""
        return self.counts and self.clearance_m < TOUCHING_M


@dataclass(frozen=True)
class Claim:
    """One detection. real: it is an object's, and the first of that object. named: it has a label other than UNKNOWN;
    right: that label is the object's."""

    real: bool
    named: bool
    right: bool


def compare(
    shot: Snapshot,
    detections: Sequence[Detection],
    calibration: Calibration,
    clearances_m: Sequence[float],
    world: str,
    frame: int,
) -> tuple[list[Seen], list[Claim]]:
    """Every object of a frame, and every detection. clearances_m: of each of the world's objects."""
    owners = [owner_of(shot, detection) for detection in detections]
    matched: dict[int, Detection] = {}
    for detection, owner in sorted(zip(detections, owners), key=lambda each: -len(each[0].cluster.indices)):
        matched.setdefault(owner, detection)
    truths = {truth.index: truth for truth in shot.truth}
    claims = []
    for detection, owner in zip(detections, owners):
        real = owner >= 0 and matched[owner] is detection
        named = detection.label != UNKNOWN
        right = real and named and owner in truths and detection.label == truths[owner].label
        claims.append(Claim(real, named, right))
    seen = [
        _seen(shot, truth, matched.get(truth.index), calibration, clearances_m[truth.index], world, frame)
        for truth in shot.truth
    ]
    return seen, claims


def owner_of(shot: Snapshot, detection: Detection) -> int:
    """Whose surface most of the cluster's beams met."""
    owners, counts = np.unique(shot.owners[detection.cluster.indices], return_counts=True)
    return int(owners[counts.argmax()])


def _seen(
    shot: Snapshot,
    truth: ObjectTruth,
    detection: Detection | None,
    calibration: Calibration,
    clearance_m: float,
    world: str,
    frame: int,
) -> Seen:
    beams = _beams_in_view(shot.scan, np.flatnonzero(shot.owners == truth.index), calibration)
    about = Seen(
        world=world,
        frame=frame,
        kind=truth.kind,
        label=truth.label,
        range_m=truth.range_m,
        beams=beams,
        in_view=beams / max(1, truth.beams),
        occlusion=truth.occlusion,
        clearance_m=clearance_m,
        found=False,
    )
    return about if detection is None else _with_errors(about, truth, detection)


def _with_errors(about: Seen, truth: ObjectTruth, detection: Detection) -> Seen:
    found, true = detection.box, truth.box
    height_px, true_height_px = found[3] - found[1], true[3] - true[1]
    return replace(
        about,
        found=True,
        said=detection.label,
        named=detection.label == truth.label,
        iou=iou(found, true),
        height_error=(height_px - true_height_px) / true_height_px,
        width_error_px=float((found[2] - found[0]) - (true[2] - true[0])),
        distance_error_m=detection.distance_m - truth.range_m,
        sigma_m=detection.distance_sigma_m,
    )


def _beams_in_view(scan: Scan, beams: npt.NDArray[np.intp], calibration: Calibration) -> int:
    """How many of these beams fall into the image, dropped ones left out."""
    ranges_m, angles = scan.ranges_m[beams].astype(float), scan.angles[beams]
    measured = np.isfinite(ranges_m)
    ranges_m, angles = ranges_m[measured], angles[measured]
    points = np.stack([ranges_m * np.cos(angles), ranges_m * np.sin(angles), np.zeros(len(ranges_m))], axis=1)
    pixels, _ = project(points, calibration.camera, calibration.T_camera_laser)
    inside = (pixels >= 0).all(axis=1) & (pixels < calibration.image_size).all(axis=1)
    return int(inside.sum())
