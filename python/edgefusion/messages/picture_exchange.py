# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What base and vision say to each other at an inspection, as JSON: a request for a picture, and the answer to it."""

from __future__ import annotations

from typing import Literal, Optional, Union

import msgspec

from edgefusion.messages.detections_detail import DetectionDetail
from edgefusion.messages.json_text import from_text, to_text
from edgefusion.messages.mission_report import Place
from edgefusion.messages.std_msgs import String


class PictureRequestDetail(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """`inspection/request`, which base repeats until it is answered or too late: whoever answers does it once.

    Fields as in navigation's PictureRequest: a picture of what stands at place_m, in `odom`, taken from stamp_ns on.
    """

    version: Literal[1] = 1
    id: str
    label: str
    group: str
    place_m: Place
    stamp_ns: int
    deadline_ns: int


class PictureAnswerDetail(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """`inspection/answer`. jpeg: the picture taken at stamp_ns, with the object's box where it was seen; None: there is
    none, and reason says why. detection: what was seen of the object in it."""

    version: Literal[1] = 1
    request_id: str
    stamp_ns: int
    jpeg: Optional[bytes] = None
    detection: Optional[DetectionDetail] = None
    reason: str = ""


def from_picture_exchange(detail: Union[PictureRequestDetail, PictureAnswerDetail]) -> String:
    """For `inspection/request` and `inspection/answer`."""
    return to_text(detail)


def to_picture_request(message: String) -> PictureRequestDetail:
    """Raises WireError for anything else."""
    return from_text(message, PictureRequestDetail, "inspection/request")


def to_picture_answer(message: String) -> PictureAnswerDetail:
    """Raises WireError for anything else."""
    return from_text(message, PictureAnswerDetail, "inspection/answer")
