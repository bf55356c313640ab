# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures of what the robot stands before: base asks for one, and is answered once. Pure: the time is passed in."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, Deque, Sequence

from edgefusion.messages.from_detections_detail import from_detection
from edgefusion.messages.picture_exchange import PictureAnswerDetail, PictureRequestDetail
from edgefusion.service.vision_look import Look
from edgefusion.types import Detection, Pose2D

LOOKS = 3
"""So many frames may not show what is asked for; the last of them is the answer then."""

MARGIN_NS = 500_000_000
"""So long before the deadline it is too late for another look: the answer has a way to go."""

_KNOWN = 32

Draw = Callable[[Look, Sequence[Detection]], bytes]
"""Makes a JPEG of a frame, with the boxes of these detections."""


class VisionInspections:
    """same_place_m: what is no farther from the place that is asked for stands there."""

    def __init__(self, same_place_m: float, draw: Draw) -> None:
        self._same_place_m, self._draw = same_place_m, draw
        self._request: PictureRequestDetail | None = None
        self._looks = 0
        self._known: Deque[str] = deque(maxlen=_KNOWN)

    def ask(self, request: PictureRequestDetail) -> None:
        """One that is known already changes nothing, one that is new replaces that which waits."""
        if request.id not in self._known:
            self._known.append(request.id)
            self._request, self._looks = request, 0

    def look(self, look: Look) -> PictureAnswerDetail | None:
        """The answer, where this look gives it: it shows the object, or it is the last that may not."""
        request = self._request
        if request is None or look.frame.stamp_ns < request.stamp_ns:
            return None
        self._looks += 1
        shown = [each for each in look.detections if self._is_it(each, request, look.pose)][:1]
        too_late = look.ended_ns > request.deadline_ns - MARGIN_NS
        if not (shown or self._looks >= LOOKS or too_late):
            return None
        self._request = None
        return PictureAnswerDetail(
            request_id=request.id,
            stamp_ns=look.frame.stamp_ns,
            jpeg=self._draw(look, shown),
            detection=from_detection(shown[0]) if shown else None,
        )

    def expire(self, now_ns: int, trouble: str) -> PictureAnswerDetail | None:
        """The answer that there is no picture, when it is too late for one. trouble: why nothing is seen."""
        request = self._request
        if request is None or now_ns <= request.deadline_ns - MARGIN_NS:
            return None
        self._request = None
        reason = trouble or "no scan and frame were captured together in time"
        return PictureAnswerDetail(request_id=request.id, stamp_ns=now_ns, reason=reason)

    def _is_it(self, detection: Detection, request: PictureRequestDetail, pose: Pose2D | None) -> bool:
        named = detection.label == request.label or (detection.group != "" and detection.group == request.group)
        if pose is None or not named:
            return False
        place, (x_m, y_m) = pose.compose(Pose2D(*detection.position_m)), request.place_m
        return math.hypot(place.x_m - x_m, place.y_m - y_m) <= self._same_place_m
