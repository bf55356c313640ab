# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Requests for pictures and their answers, between the mission and what goes over the bus."""

from __future__ import annotations

from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import WireError
from edgefusion.messages.picture_exchange import PictureRequestDetail, to_picture_answer
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_detections_detail import to_detection
from edgefusion.navigation.inspection_result import PictureAnswer, PictureRequest


def picture_request(request: PictureRequest) -> PictureRequestDetail:
    """As it is said to vision."""
    return PictureRequestDetail(
        id=request.id,
        label=request.label,
        group=request.group,
        place_m=request.place_m,
        stamp_ns=request.stamp_ns,
        deadline_ns=request.deadline_ns,
    )


def picture_answer(message: String) -> PictureAnswer:
    """Of `inspection/answer`. Raises WireError for anything else."""
    answer = to_picture_answer(message)
    try:
        detection = None if answer.detection is None else to_detection(answer.stamp_ns, answer.detection)
        return PictureAnswer(answer.request_id, answer.stamp_ns, answer.jpeg, detection, answer.reason)
    except (RefusedError, ValueError, OverflowError) as error:
        raise WireError(f"inspection/answer: {error}") from None
