# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What `detections/detail` holds as JSON: all that is known of the detections in a frame. Units as in `Detection`."""

from __future__ import annotations

from typing import List, Literal, Optional, Tuple

import msgspec

VERSION: Literal[1] = 1


class _Strict(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Neither more nor less than its fields."""


class ScoreDetail(_Strict, frozen=True):
    label: str
    class_index: int
    score: float


class VoteDetail(_Strict, frozen=True):
    ranking: List[ScoreDetail]
    box_index: int
    margin: float
    top5: List[List[ScoreDetail]]


class ClusterDetail(_Strict, frozen=True):
    indices: List[int]
    range_m: float
    bearing: float
    width_m: float


class DetectionDetail(_Strict, frozen=True):
    """motion: x, y [m] and theta; motion_px: None where the camera sees only one of the two places."""

    label: str
    group: str
    class_index: int
    score: float
    margin: float
    box: Tuple[int, int, int, int]
    distance_m: float
    distance_sigma_m: float
    bearing: float
    position_m: Tuple[float, float]
    scan_frame_dt_ns: int
    motion: Tuple[float, float, float]
    motion_px: Optional[float]
    boxes: List[Tuple[int, int, int, int]]
    vote: VoteDetail
    cluster: ClusterDetail


class DetectionsDetail(_Strict, frozen=True, kw_only=True):
    """stamp_ns: the frame's, by the robot's monotonic clock."""

    version: Literal[1] = VERSION
    stamp_ns: int
    detections: List[DetectionDetail]
