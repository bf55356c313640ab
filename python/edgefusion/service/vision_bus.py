# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Vision on the bus, from when there is one."""

from __future__ import annotations

import logging
from typing import Callable, NamedTuple, Sequence

import zenoh

from edgefusion.bus.joining import OPENING_S, Joining
from edgefusion.bus.liveliness import declare_alive
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.session import open_member
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import Topic
from edgefusion.clock import Clock
from edgefusion.config import Config
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.picture_exchange import PictureAnswerDetail, PictureRequestDetail
from edgefusion.messages.stamps import Stamper
from edgefusion.perception.calibration import Calibration
from edgefusion.service.teller import Teller
from edgefusion.service.vision_eye import Eye
from edgefusion.service.vision_inbox import VisionInbox
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_odometry import VisionOdometry
from edgefusion.service.vision_outlet import VisionOutlet
from edgefusion.service.vision_pictures import VisionPictures
from edgefusion.service.vision_watch import Status, VisionWatch
from edgefusion.types import Scan

COMPONENT = "vision"
ENDING_S = 0.5

log = logging.getLogger(__name__)


class News(NamedTuple):
    """What came since the last turn. refused: why scans do not count; empty where all do."""

    scans: Sequence[Scan] = ()
    requests: Sequence[PictureRequestDetail] = ()
    refused: str = ""


class _Joined(NamedTuple):
    """All that is on the bus; the token is alive while it is kept."""

    inbox: VisionInbox
    outlet: VisionOutlet
    watch: VisionWatch
    token: zenoh.LivelinessToken


class VisionBus:
    """take(), tell() and answer() are for the loop's thread. wake: called when a scan comes. status: the detector's.
    clock_id: of the clock that stamps are of."""

    def __init__(
        self,
        config: Config,
        calibration: Calibration,
        eye: Eye,
        pictures: VisionPictures,
        stamper: Stamper,
        status: Callable[[], Status | None],
        wake: Callable[[], None],
        clock: Clock,
        clock_id: str,
    ) -> None:
        self._config, self._calibration, self._eye = config, calibration, eye
        self._pictures, self._stamper, self._status = pictures, stamper, status
        self._wake, self._clock, self._clock_id = wake, clock, clock_id
        self._joined: _Joined | None = None
        self._joining = Joining(lambda: open_member(config.bus, OPENING_S), self._join)
        self.tell: Teller[Look] = Teller("publishing", self._tell)

    def begin(self) -> None:
        """Returns at once."""
        self.tell.begin()
        self._joining.begin()

    def end(self) -> None:
        """Leaves the bus."""
        self.tell.end(ENDING_S)
        if self._joined is not None:
            self._joined.watch.end(ENDING_S)
        self._joining.end()

    def take(self, odometry: VisionOdometry) -> News:
        """What came since the last time; the odometry is told where the robot was. Never waits.

        Raises what has kept it from joining the bus for good.
        """
        if self._joining.failure is not None:
            raise self._joining.failure
        joined = self._joined
        if joined is None:
            return News()
        joined.inbox.report_to(odometry)
        return News(joined.inbox.scans(), joined.inbox.requests(), joined.inbox.refusal)

    def answer(self, answer: PictureAnswerDetail) -> None:
        """To a request."""
        if self._joined is not None:
            self._joined.outlet.answer(answer)

    def _tell(self, look: Look) -> None:
        if self._joined is not None:
            self._joined.outlet.tell(look)

    def _join(self, session: zenoh.Session) -> None:
        config, calibration, clock = self._config, self._calibration, self._clock
        robot, tagger = config.bus.robot, Tagger()

        def publisher(topic: Topic, max_hz: float) -> Publisher:
            return Publisher(session, robot, topic, tagger, self._clock_id, max_hz)

        inbox = VisionInbox(session, robot, self._clock_id, calibration.laser_latency_ns, self._wake, clock)
        outlet = VisionOutlet(publisher, config, calibration, self._pictures, self._stamper, clock)
        camera = Intrinsics(calibration.image_size, calibration.K, calibration.distortion)
        watch = VisionWatch(publisher, self._eye, self._status, camera, config.bus, self._stamper, clock)
        watch.begin()
        self._joined = _Joined(inbox, outlet, watch, declare_alive(session, robot, COMPONENT))
        log.info("bus: joined at %s", config.bus.router)
