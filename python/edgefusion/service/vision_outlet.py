# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What vision tells of each look on the bus, as far as somebody listens."""

from __future__ import annotations

import math
from typing import Callable

from edgefusion.bus import topics
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.topics import Topic
from edgefusion.clock import Clock
from edgefusion.config import Config
from edgefusion.messages.camera_view import CameraView
from edgefusion.messages.from_clusters import from_clusters
from edgefusion.messages.from_detections import from_detections
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.from_jpeg import from_jpeg
from edgefusion.messages.picture_exchange import PictureAnswerDetail, from_picture_exchange
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import find_clusters
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_pictures import VisionPictures

MakePublisher = Callable[[Topic, float], Publisher]
ALL_HZ = 1e9


class VisionOutlet:
    """tell() is for one thread, answer() for one. publisher: makes one of a topic, of so many a second at most."""

    def __init__(
        self,
        publisher: MakePublisher,
        config: Config,
        calibration: Calibration,
        pictures: VisionPictures,
        stamper: Stamper,
        clock: Clock,
    ) -> None:
        self._config, self._calibration, self._pictures = config, calibration, pictures
        self._stamper, self._clock = stamper, clock
        self._detections, self._detail = (
            publisher(topics.DETECTIONS, ALL_HZ),
            publisher(topics.DETECTIONS_DETAIL, ALL_HZ),
        )
        self._clusters = publisher(topics.CLUSTERS, ALL_HZ)
        self._annotated = publisher(topics.ANNOTATED, config.bus.annotated_hz)
        self._answers = publisher(topics.INSPECTION_ANSWER, ALL_HZ)

    def tell(self, look: Look) -> None:
        """What is wanted of a look, what others drive by first."""
        stamp_ns, now_ns = look.frame.stamp_ns, self._clock()
        if self._detail.wanted(now_ns):
            self._detail.put(from_detections_detail(stamp_ns, look.detections), stamp_ns)
        if self._detections.wanted(now_ns):
            self._detections.put(from_detections(stamp_ns, look.detections, self._view(look), self._stamper), stamp_ns)
        if self._clusters.wanted(now_ns):
            clusters = find_clusters(look.scan, self._config.perception)
            self._clusters.put(from_clusters(look.scan, clusters, self._stamper), look.scan.stamp_ns)
        if self._annotated.wanted(now_ns):
            jpeg = self._pictures.annotated(look, look.detections)
            self._annotated.put(from_jpeg(stamp_ns, jpeg, self._stamper), stamp_ns)

    def answer(self, answer: PictureAnswerDetail) -> None:
        """To the base, where it listens still."""
        if self._answers.wanted(self._clock()):
            self._answers.put(from_picture_exchange(answer), answer.stamp_ns)

    def _view(self, look: Look) -> CameraView:
        """A surface is anywhere between the beams beside it."""
        bearing_sigma = abs(look.scan.angle_increment) / math.sqrt(12)
        return CameraView(self._calibration.T_camera_laser, self._calibration.T_base_laser, bearing_sigma)
