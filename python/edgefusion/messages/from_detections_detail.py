# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections as the JSON of `detections/detail`."""

from __future__ import annotations

from typing import Sequence

from edgefusion.messages.detections_detail import (
    ClusterDetail,
    DetectionDetail,
    DetectionsDetail,
    ScoreDetail,
    VoteDetail,
)
from edgefusion.messages.json_text import number, number_or_none, to_text
from edgefusion.messages.std_msgs import String
from edgefusion.types import ClassScore, Cluster, Detection, Vote


def from_detections_detail(stamp_ns: int, detections: Sequence[Detection]) -> String:
    """All that is known of the detections in the frame of that stamp, exactly.

    Raises RefusedError for a detection with a number that is not finite.
    """
    return to_text(DetectionsDetail(stamp_ns=stamp_ns, detections=[from_detection(each) for each in detections]))


def from_detection(detection: Detection) -> DetectionDetail:
    """One of them. Raises RefusedError as from_detections_detail."""
    motion = detection.motion
    x_m, y_m = detection.position_m
    return DetectionDetail(
        label=detection.label,
        group=detection.group,
        class_index=detection.class_index,
        score=number(detection.score, "score"),
        margin=number(detection.margin, "margin"),
        box=detection.box,
        distance_m=number(detection.distance_m, "distance_m"),
        distance_sigma_m=number(detection.distance_sigma_m, "distance_sigma_m"),
        bearing=number(detection.bearing, "bearing"),
        position_m=(number(x_m, "position_m"), number(y_m, "position_m")),
        scan_frame_dt_ns=detection.scan_frame_dt_ns,
        motion=(motion.x_m, motion.y_m, motion.theta),
        motion_px=number_or_none(detection.motion_px),
        boxes=list(detection.boxes),
        vote=_vote(detection.vote),
        cluster=_cluster(detection.cluster),
    )


def _vote(vote: Vote) -> VoteDetail:
    return VoteDetail(
        ranking=[_score(each) for each in vote.ranking],
        box_index=vote.box_index,
        margin=number(vote.margin, "vote.margin"),
        top5=[[_score(each) for each in box] for box in vote.top5],
    )


def _score(score: ClassScore) -> ScoreDetail:
    return ScoreDetail(label=score.label, class_index=score.class_index, score=number(score.score, "vote.score"))


def _cluster(cluster: Cluster) -> ClusterDetail:
    return ClusterDetail(
        indices=cluster.indices.tolist(),
        range_m=number(cluster.range_m, "cluster.range_m"),
        bearing=number(cluster.bearing, "cluster.bearing"),
        width_m=number(cluster.width_m, "cluster.width_m"),
    )
