# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections as Detection2DArray."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from edgefusion.messages.camera_view import CameraView
from edgefusion.messages.frames import CAMERA_OPTICAL
from edgefusion.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.std_msgs import Header
from edgefusion.messages.vision_msgs import (
    BoundingBox2D,
    Detection2D,
    Detection2DArray,
    ObjectHypothesis,
    ObjectHypothesisWithPose,
    Point2D,
    Pose2D,
)
from edgefusion.types import Box, Detection

_RUNNERS_UP = 4
_ANY_ROTATION = math.pi**2
"""Variance [rad^2] of what is not known: a laser that sees a line does not see how a thing is turned."""


def from_detections(
    stamp_ns: int, detections: Sequence[Detection], view: CameraView, stamper: Stamper
) -> Detection2DArray:
    """Of the frame captured then. Of each, first the label that it got and then the best that it did not get."""
    header = stamper.header(stamp_ns, CAMERA_OPTICAL)
    return Detection2DArray(header, [_detection(header, each, view) for each in detections])


def _detection(header: Header, detection: Detection, view: CameraView) -> Detection2D:
    named = [(detection.label, detection.score)]
    runners_up = [(each.label, each.score) for each in detection.vote.ranking[1 : 1 + _RUNNERS_UP]]
    pose = _pose(detection, view)
    results = [ObjectHypothesisWithPose(ObjectHypothesis(*each), pose) for each in named + runners_up]
    return Detection2D(header, results, _bounding_box(detection.box))


def _bounding_box(box: Box) -> BoundingBox2D:
    x0, y0, x1, y1 = box
    return BoundingBox2D(Pose2D(Point2D((x0 + x1) / 2, (y0 + y1) / 2)), float(x1 - x0), float(y1 - y0))


def _pose(detection: Detection, view: CameraView) -> PoseWithCovariance:
    covariance = np.diag([0.0, 0.0, 0.0, _ANY_ROTATION, _ANY_ROTATION, _ANY_ROTATION])
    covariance[:3, :3] = view.covariance(detection)
    return PoseWithCovariance(Pose(Point(*view.position_m(detection).tolist())), covariance.ravel().tolist())
