# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections from the JSON of `detections/detail`."""

from __future__ import annotations

from typing import NamedTuple, Sequence, Tuple

import numpy as np

from edgefusion.messages.cdr import WireError
from edgefusion.messages.detections_detail import (
    ClusterDetail,
    DetectionDetail,
    DetectionsDetail,
    ScoreDetail,
    VoteDetail,
)
from edgefusion.messages.json_text import from_text
from edgefusion.messages.std_msgs import String
from edgefusion.types import ClassScore, Cluster, Detection, Pose2D, Vote, read_only

_NAME = "detections/detail"


class Detections(NamedTuple):
    """Those in a frame, which may have none. stamp_ns: the frame's, by the robot's monotonic clock."""

    stamp_ns: int
    detections: Tuple[Detection, ...]


def to_detections_detail(message: String) -> Detections:
    """As they were on the robot. Raises WireError for anything else."""
    detail = from_text(message, DetectionsDetail, _NAME)
    try:
        return Detections(detail.stamp_ns, tuple(to_detection(detail.stamp_ns, each) for each in detail.detections))
    except (ValueError, OverflowError) as error:  # an index that fits into no 64 bits
        raise WireError(f"{_NAME}: {error}") from None


def to_detection(stamp_ns: int, detail: DetectionDetail) -> Detection:
    """One of them, in the frame of that stamp. Raises ValueError, OverflowError for what is none."""
    return Detection(
        stamp_ns=stamp_ns,
        class_index=detail.class_index,
        label=detail.label,
        group=detail.group,
        score=detail.score,
        margin=detail.margin,
        box=detail.box,
        distance_m=detail.distance_m,
        distance_sigma_m=detail.distance_sigma_m,
        bearing=detail.bearing,
        position_m=detail.position_m,
        vote=_vote(detail.vote, len(detail.boxes)),
        boxes=tuple(detail.boxes),
        cluster=_cluster(detail.cluster),
        scan_frame_dt_ns=detail.scan_frame_dt_ns,
        motion=Pose2D(*detail.motion),
        motion_px=np.nan if detail.motion_px is None else detail.motion_px,
    )


def _vote(detail: VoteDetail, boxes: int) -> Vote:
    if not detail.ranking:
        raise WireError("ranking: expected at least one class, got none")
    if len(detail.top5) != boxes or not 0 <= detail.box_index < boxes:
        raise WireError(f"boxes: {boxes}, but {len(detail.top5)} votes, the best of them number {detail.box_index}")
    return Vote(
        ranking=_scores(detail.ranking),
        box_index=detail.box_index,
        margin=detail.margin,
        top5=tuple(map(_scores, detail.top5)),
    )


def _scores(details: Sequence[ScoreDetail]) -> Tuple[ClassScore, ...]:
    return tuple(ClassScore(each.class_index, each.label, each.score) for each in details)


def _cluster(detail: ClusterDetail) -> Cluster:
    return Cluster(read_only(np.array(detail.indices, np.int64)), detail.range_m, detail.bearing, detail.width_m)
