# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Algorithm 1 of the paper: a scan and a frame in, the names and distances of the nearest objects out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.clock import Clock, system_clock
from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.candidates import Candidate, batch_of, find_candidates, split
from edgefusion.perception.classifier import Classifier
from edgefusion.perception.distance import nearest_surface
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.height_rule import choose_box
from edgefusion.perception.motion import laser_motion, shift_px, transform
from edgefusion.perception.voting import vote
from edgefusion.types import BACKGROUND, STILL, UNKNOWN, Box, Detection, Frame, Pose2D, Scan, Vote


@dataclass(frozen=True)
class StageTimes:
    """What one frame took, in nanoseconds."""

    cluster_ns: int
    crop_ns: int
    infer_ns: int
    vote_ns: int


class Detector:
    """The perception system. A frame's answer depends on nothing before it; `times` says what the last one took."""

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
        self._config = _as_trained(config or PerceptionConfig(), classifier)
        self._groups = groups or LabelGroups.load()
        self._clock = clock
        self.times = StageTimes(0, 0, 0, 0)

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> list[Detection]:
        """The objects in front of the robot, nearest first. Step 1, the pairing, is `sync`.

        motion: the robot's pose at the frame's stamp in its base_link at the scan's stamp, STILL if unknown.
        Raises ValueError for a frame that is not of the calibration's size; never for geometry.
        """
        self._check_size(frame)
        ticks = [self._clock()]
        T_moved = laser_motion(motion, self._calibration.T_base_laser)
        T_camera_laser = self._calibration.T_camera_laser @ T_moved
        candidates = find_candidates(scan, T_camera_laser, self._calibration, self._config)  # steps 2-6, eq. (1)
        ticks.append(self._clock())
        crops = self._classifier.crop(frame.image, batch_of(candidates))  # step 7
        ticks.append(self._clock())
        probabilities = self._classifier.infer(crops)
        ticks.append(self._clock())
        detections = []
        for candidate, rows in zip(candidates, split(probabilities, candidates)):
            ballot = vote(rows, self._classifier.labels)  # step 8
            if ballot is not None:  # None: the network had no answer for any of the boxes
                box = choose_box(self._config.height_rule or "paper", ballot, candidate.boxes, rows)
                detections.append(self._detection(scan, frame, motion, T_moved, candidate, ballot, box))
        ticks.append(self._clock())
        self.times = StageTimes(*(after - before for before, after in zip(ticks, ticks[1:])))
        return sorted(detections, key=lambda detection: detection.distance_m)

    def _detection(
        self,
        scan: Scan,
        frame: Frame,
        motion: Pose2D,
        T_moved: npt.NDArray[np.float64],
        candidate: Candidate,
        ballot: Vote,
        box: Box,
    ) -> Detection:
        """Step 9: the answer, with the nearest surface where it was at the frame's stamp."""
        winner = ballot.winner
        strong = winner.score >= self._config.min_score and ballot.margin >= self._config.min_margin
        named = strong and winner.label != BACKGROUND
        surface = nearest_surface(scan, candidate.cluster, self._config)
        moved = transform(T_moved, surface.point())
        T_base_laser = self._calibration.T_base_laser
        ahead_m, left_m, _ = (T_base_laser[:3, :3] @ moved).tolist()  # from the laser, in base_link's axes
        x_m, y_m, _ = transform(T_base_laser, moved).tolist()
        return Detection(
            stamp_ns=frame.stamp_ns,
            class_index=winner.class_index,
            label=winner.label if named else UNKNOWN,
            group=self._groups.group_of(winner.label) if named else "",
            score=winner.score,
            margin=ballot.margin,
            box=box,
            distance_m=float(np.linalg.norm(moved)),
            distance_sigma_m=surface.sigma_m,
            bearing=math.atan2(left_m, ahead_m),
            position_m=(x_m, y_m),
            vote=ballot,
            boxes=tuple(tuple(each) for each in candidate.boxes.tolist()),
            cluster=candidate.cluster,
            scan_frame_dt_ns=frame.stamp_ns - scan.stamp_ns,
            motion=motion,
            motion_px=0.0 if motion == STILL else shift_px(surface.point(), moved, self._calibration),
        )

    def _check_size(self, frame: Frame) -> None:
        height, width = frame.image.shape[:2]
        if (width, height) != tuple(self._calibration.image_size):
            expected = "x".join(map(str, self._calibration.image_size))
            raise ValueError(f"image: the calibration expects {expected}, got {width}x{height}")


def _as_trained(config: PerceptionConfig, classifier: Classifier) -> PerceptionConfig:
    """The settings; where they do not say which heights to try and how to choose, as the model was trained for."""
    boxes = classifier.boxes
    if config.heights is not None or boxes is None:
        return config
    rule = config.height_rule or boxes.height_rule
    return msgspec.structs.replace(config, heights=boxes.heights, heights_in=boxes.heights_in, height_rule=rule)
