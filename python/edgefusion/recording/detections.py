# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections as lines of JSON: everything that is known of each, one line per detection."""

from __future__ import annotations

from typing import Any

import msgspec

from edgefusion.types import ClassScore, Detection


def to_json_line(frame: int, detection: Detection) -> bytes:
    """One line, with its end, for a detection in frame number `frame`."""
    return msgspec.json.encode(as_record(frame, detection)) + b"\n"


def as_record(frame: int, detection: Detection) -> dict[str, Any]:
    """The fields of a detection in frame number `frame` as plain values; of its vote, the best of all and of each
    box."""
    return {
        "frame": frame,
        **_plain_fields(detection),
        "runners_up": [_score(score) for score in detection.vote.ranking[1:5]],
        "boxes": detection.boxes,
        "top5": [[_score(score) for score in box] for box in detection.vote.top5],
    }


def with_whole_vote(detection: Detection) -> dict[str, Any]:
    """The fields of a detection as plain values, and all of its vote."""
    vote = detection.vote
    return {
        **_plain_fields(detection),
        "boxes": detection.boxes,
        "vote": {
            "ranking": [_score(score) for score in vote.ranking],
            "box_index": vote.box_index,
            "margin": _rounded(vote.margin),
            "top5": [[_score(score) for score in box] for box in vote.top5],
        },
    }


def _plain_fields(detection: Detection) -> dict[str, Any]:
    """What a detection is beside its vote; units and frames as in `Detection`."""
    return {
        "stamp_ns": detection.stamp_ns,
        "label": detection.label,
        "group": detection.group,
        "class_index": detection.class_index,
        "score": _rounded(detection.score),
        "margin": _rounded(detection.margin),
        "box": detection.box,
        "distance_m": _rounded(detection.distance_m),
        "distance_sigma_m": _rounded(detection.distance_sigma_m),
        "bearing": _rounded(detection.bearing),
        "position_m": [_rounded(value) for value in detection.position_m],
        "scan_frame_dt_ns": detection.scan_frame_dt_ns,
        "motion": [detection.motion.x_m, detection.motion.y_m, detection.motion.theta],
        "motion_px": _rounded(detection.motion_px),
    }


def _score(score: ClassScore) -> dict[str, Any]:
    return {"label": score.label, "class_index": score.class_index, "score": _rounded(score.score)}


def _rounded(value: float) -> float:
    # A float of the network printed in full would suggest digits that are not there.
    return round(float(value), 5)
