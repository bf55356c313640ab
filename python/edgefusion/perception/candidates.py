# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which clusters may be objects that the camera sees, and the boxes that may hold each: steps 5 and 6."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from edgefusion._core import candidate_boxes
from edgefusion.config import USUAL_HEIGHTS, PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import find_clusters
from edgefusion.types import Cluster, Scan

Matrix = npt.NDArray[np.float64]
Boxes = npt.NDArray[np.int32]
Probabilities = npt.NDArray[np.float32]


BESIDE = 3
"""Beams beside a cluster's end that tell what is behind it: the first may be dropped, or lie on both."""


@dataclass(frozen=True)
class Candidate:
    """A cluster that the camera sees, and the boxes int32[k, 4] that may hold it."""

    cluster: Cluster
    boxes: Boxes


def find_candidates(
    scan: Scan, T_camera_laser: Matrix, calibration: Calibration, config: PerceptionConfig
) -> list[Candidate]:
    """The nearest clusters that are no wall and project into the image, nearest first.

    T_camera_laser: from laser coordinates at the scan's stamp into camera coordinates at the frame's.
    """
    candidates: list[Candidate] = []
    for cluster in find_clusters(scan, config):
        if len(candidates) == config.objects:
            break
        if _is_wall(scan, cluster, config):
            continue
        boxes = _boxes(scan, cluster, T_camera_laser, calibration, config)
        if len(boxes):
            candidates.append(Candidate(cluster, boxes))
    return candidates


def _is_wall(scan: Scan, cluster: Cluster, config: PerceptionConfig) -> bool:
    """Too wide for an object, or wide and not standing out at both ends."""
    if cluster.width_m > config.max_object_width_m:
        return True
    return cluster.width_m > config.max_flush_width_m and not _stands_out(scan, cluster, config.eps_m)


def _stands_out(scan: Scan, cluster: Cluster, step_m: float) -> bool:
    """Whether the beams beside both ends go farther than the ends do; beside the scan's own ends nothing is known."""
    first, last = int(cluster.indices[0]), int(cluster.indices[-1])
    right, left = scan.ranges_m[max(0, first - BESIDE) : first], scan.ranges_m[last + 1 : last + 1 + BESIDE]
    # NaN, a beam without an answer, is farther than nothing.
    return bool((right > scan.ranges_m[first] + step_m).any() and (left > scan.ranges_m[last] + step_m).any())


def batch_of(candidates: list[Candidate]) -> Boxes:
    """The boxes of all candidates, int32[n, 4]."""
    return np.concatenate([candidate.boxes for candidate in candidates] or [np.empty((0, 4), np.int32)])


def split(rows: Probabilities, candidates: list[Candidate]) -> list[Probabilities]:
    """The rows of a batch that belong to each candidate."""
    ends = list(accumulate(len(candidate.boxes) for candidate in candidates))
    return [rows[begin:end] for begin, end in zip([0, *ends], ends)]  # np.split takes ten times as long


def _boxes(
    scan: Scan, cluster: Cluster, T_camera_laser: Matrix, calibration: Calibration, config: PerceptionConfig
) -> Boxes:
    width, height = calibration.image_size
    boxes, _ = candidate_boxes(
        scan.ranges_m[cluster.indices],
        scan.angle_min + scan.angle_increment * cluster.indices,
        2 * config.margin_steps * abs(scan.angle_increment),  # half of it on either side
        calibration.camera,
        T_camera_laser,
        calibration.to_ground,
        width,
        height,
        config.heights or USUAL_HEIGHTS,
        heights_are_metric=config.heights_in == "metres",
        width_step=config.width_step,
        on_ground=config.bottom == "ground",
        min_visible=config.min_visible,
    )
    return boxes
