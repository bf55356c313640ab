# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Algorithm 1 of the paper: a scan and a frame in, the names and distances of the nearest objects out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator

import numpy as np
import numpy.typing as npt

from edgefusion._core import candidate_boxes
from edgefusion.clock import Clock, system_clock
from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.classifier import Classifier
from edgefusion.perception.clusters import find_clusters
from edgefusion.perception.distance import nearest_surface
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.height_rule import choose_box
from edgefusion.perception.motion import laser_motion, shift_px, transform
from edgefusion.perception.voting import vote
from edgefusion.types import STILL, UNKNOWN, Box, Cluster, Detection, Frame, Pose2D, Scan, Vote

Matrix = npt.NDArray[np.float64]
Boxes = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Candidate:
    """A cluster that the camera sees, and the boxes int32[k, 4] that may hold it."""

    cluster: Cluster
    boxes: Boxes


@dataclass(frozen=True)
class StageTimes:
    """What one frame took, in nanoseconds."""

    cluster_ns: int
    crop_ns: int
    infer_ns: int
    vote_ns: int


class Detector:
    """The perception system. Holds no state between frames but the times of the last one."""

    def __init__(
        self,
        classifier: Classifier,
        calibration: Calibration,
        config: PerceptionConfig | None = None,
        groups: LabelGroups | None = None,
        clock: Clock = system_clock,
    ) -> None:
        self._classifier = classifier
        self._calibration = calibration
        self._config = config or PerceptionConfig()
        self._groups = groups or LabelGroups.load()
        self._clock = clock
        self.times = StageTimes(0, 0, 0, 0)

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> list[Detection]:
        """The objects in front of the robot, nearest first.

        motion: the robot's pose at the frame's stamp in its base_link at the scan's stamp, STILL if unknown.
        Raises ValueError for a frame that is not of the calibration's size; never for geometry.
        """
        self._check_size(frame)
        start = self._clock()
        T_laser = laser_motion(motion, self._calibration.T_base_laser)  # undoes the motion since the scan
        T_camera_laser = self._calibration.T_camera_laser @ T_laser
        candidates = self._candidates(scan, T_camera_laser)  # steps 2 to 6, eqs. (1) to (3)
        boxes = np.concatenate([c.boxes for c in candidates] or [np.empty((0, 4), np.int32)])
        clustered = self._clock()
        crops = self._classifier.crop(frame.image, boxes)  # step 7: one batch for all
        cropped = self._clock()
        probabilities = self._classifier.infer(crops)
        inferred = self._clock()
        detections = [
            self._detection(scan, frame, motion, T_laser, candidate, mine)  # steps 8 and 9
            for candidate, mine in zip(candidates, _split(probabilities, candidates))
            if np.isfinite(mine).all(axis=1).any()
        ]
        self.times = StageTimes(
            clustered - start, cropped - clustered, inferred - cropped, self._clock() - inferred
        )
        return detections

    def _candidates(self, scan: Scan, T_camera_laser: Matrix) -> list[Candidate]:
        """The nearest clusters that are no wall and project into the image, with their candidate boxes."""
        candidates: list[Candidate] = []
        for cluster in find_clusters(scan, self._config):
            if len(candidates) == self._config.objects:
                break
            if cluster.width_m > self._config.max_object_width_m:
                continue
            boxes = self._boxes(scan, cluster, T_camera_laser)
            if len(boxes):
                candidates.append(Candidate(cluster, boxes))
        return candidates

    def _boxes(self, scan: Scan, cluster: Cluster, T_camera_laser: Matrix) -> Boxes:
        width, height = self._calibration.image_size
        boxes, _ = candidate_boxes(
            scan.ranges_m[cluster.indices],
            scan.angle_min + scan.angle_increment * cluster.indices,
            abs(scan.angle_increment),
            self._calibration.camera,
            T_camera_laser,
            self._calibration.to_ground,
            width,
            height,
            self._config.heights,
            heights_are_metric=self._config.heights_in == "metres",
            width_step=self._config.width_step,
            on_ground=self._config.bottom == "ground",
            min_visible=self._config.min_visible,
        )
        return boxes

    def _detection(
        self, scan: Scan, frame: Frame, motion: Pose2D, T_laser: Matrix, candidate: Candidate, probabilities: Matrix
    ) -> Detection:
        ballot = vote(probabilities, self._classifier.labels)
        winner = ballot.winner
        named = winner.score >= self._config.min_score and ballot.margin >= self._config.min_margin
        surface = nearest_surface(scan, candidate.cluster, self._config)
        moved = transform(T_laser, surface.point())
        in_base = transform(self._calibration.T_base_laser, moved)
        return Detection(
            stamp_ns=frame.stamp_ns,
            class_index=winner.class_index,
            label=winner.label if named else UNKNOWN,
            group=self._groups.group_of(winner.label) if named else "",
            score=winner.score,
            margin=ballot.margin,
            box=self._box(ballot, candidate.boxes, probabilities),
            distance_m=float(np.hypot(moved[0], moved[1])),
            distance_sigma_m=surface.sigma_m,
            bearing=float(np.arctan2(moved[1], moved[0])),
            position_m=(float(in_base[0]), float(in_base[1])),
            vote=ballot,
            boxes=tuple(_as_box(box) for box in candidate.boxes),
            cluster=candidate.cluster,
            scan_frame_dt_ns=frame.stamp_ns - scan.stamp_ns,
            motion=motion,
            motion_px=0.0 if motion == STILL else shift_px(surface.point(), moved, self._calibration),
        )

    def _box(self, ballot: Vote, boxes: Boxes, probabilities: Matrix) -> Box:
        return choose_box(
            self._config.height_rule, ballot, boxes, probabilities[:, ballot.winner.class_index]
        )

    def _check_size(self, frame: Frame) -> None:
        height, width = frame.image.shape[:2]
        if (width, height) != tuple(self._calibration.image_size):
            expected = "x".join(map(str, self._calibration.image_size))
            raise ValueError(f"image: the calibration expects {expected}, got {width}x{height}")


def _as_box(box: npt.NDArray[np.int32]) -> Box:
    x0, y0, x1, y1 = (int(edge) for edge in box)
    return x0, y0, x1, y1


def _split(probabilities: Matrix, candidates: list[Candidate]) -> Iterator[Matrix]:
    """The rows of the batch that belong to each candidate."""
    end = 0
    for candidate in candidates:
        start, end = end, end + len(candidate.boxes)
        yield probabilities[start:end]
