# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What comes to vision over the bus: scans and odometry, of its own clock alone, and requests for pictures."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, List

import zenoh

from edgefusion.bus.feed import Feed
from edgefusion.bus.topics import INSPECTION_REQUEST, ODOM, SCAN
from edgefusion.clock import Clock
from edgefusion.messages.nav_msgs import Odometry
from edgefusion.messages.picture_exchange import PictureRequestDetail, to_picture_request
from edgefusion.messages.sensor_msgs import LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_odometry import Reckoning, to_odometry
from edgefusion.messages.to_scan import to_scan
from edgefusion.service.vision_odometry import VisionOdometry
from edgefusion.types import Scan

SCANS, REPORTS, REQUESTS = 4, 64, 4
"""So many wait for a detector that is busy: the newest."""


class VisionInbox:
    """For one thread. clock_id: of the clock that stamps must be of. wake: is called when a scan comes.

    latency_ns: the calibration's, from the middle beam to the stamp that scans carry.
    """

    def __init__(
        self,
        session: zenoh.Session,
        robot: str,
        clock_id: str,
        latency_ns: int,
        wake: Callable[[], None],
        clock: Clock,
    ) -> None:
        self._latency_ns = latency_ns
        self._scans: Feed[Scan] = Feed(session, robot, SCAN, _scan, clock_id, SCANS, wake, clock)
        self._odometry: Feed[Reckoning] = Feed(session, robot, ODOM, _reckoning, clock_id, REPORTS, clock=clock)
        self._requests = Feed(session, robot, INSPECTION_REQUEST, to_picture_request, clock_id, REQUESTS, clock=clock)

    def scans(self) -> List[Scan]:
        """Those that came, stamped with when their middle beams were measured."""
        return [replace(scan, stamp_ns=tag.stamp_ns - self._latency_ns) for tag, scan in self._scans.take()]

    def report_to(self, odometry: VisionOdometry) -> None:
        """Where the robot was since the last time."""
        for tag, reckoning in self._odometry.take():
            odometry.report(tag.session, reckoning._replace(stamp_ns=tag.stamp_ns))

    def requests(self) -> List[PictureRequestDetail]:
        """Those that came, also again."""
        return [request for _, request in self._requests.take()]

    @property
    def refusal(self) -> str:
        """Why the newest scan that did not count did not; empty where all have."""
        return self._scans.reason


def _scan(message: LaserScan) -> Scan:
    return to_scan(message, Stamper())


def _reckoning(message: Odometry) -> Reckoning:
    return to_odometry(message, Stamper())
