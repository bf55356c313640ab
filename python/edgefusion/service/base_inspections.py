# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Inspections as they go over the bus: vision is asked for the picture, and everyone gets it at the end."""

from __future__ import annotations

from typing import Callable

from edgefusion.bus import topics
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.topics import Topic
from edgefusion.messages.from_jpeg import from_jpeg
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.picture_exchange import from_picture_exchange
from edgefusion.messages.stamps import Stamper
from edgefusion.navigation.inspection_result import InspectionResult, PictureRequest
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.base_reports import inspection_report
from edgefusion.service.picture_exchange import picture_request

AGAIN_HZ = 5.0
"""What is put on the bus may be lost: a request is said again until the inspection has ended, or it is too late."""


class InspectionOutlet:
    """publisher: makes one of a topic."""

    def __init__(self, publisher: Callable[[Topic, float], Publisher], stamper: Stamper) -> None:
        self._stamper = stamper
        self._ask = publisher(topics.INSPECTION_REQUEST, AGAIN_HZ)
        self._picture, self._meta = publisher(topics.INSPECTION, 1e9), publisher(topics.INSPECTION_META, 1e9)
        self._request: PictureRequest | None = None

    def tell(self, outputs: Outputs) -> None:
        """What is due of a step of the loop."""
        step = outputs.mission
        self._request = step.request or self._request
        if step.result is not None:
            self._request = None
            self._tell_result(outputs.stamp_ns, step.result)
        self._repeat(outputs.stamp_ns)

    def _repeat(self, now_ns: int) -> None:
        request = self._request
        if request is not None and now_ns <= request.deadline_ns and self._ask.wanted(now_ns):
            self._ask.put(from_picture_exchange(picture_request(request)), now_ns)

    def _tell_result(self, now_ns: int, result: InspectionResult) -> None:
        """The picture is one of vision's, who sends JPEG."""
        picture = result.picture
        if picture is not None and self._picture.wanted(now_ns):
            self._picture.put(from_jpeg(picture.stamp_ns, picture.image, self._stamper), picture.stamp_ns)
        if self._meta.wanted(now_ns):
            self._meta.put(from_mission(inspection_report(result)), now_ns)
