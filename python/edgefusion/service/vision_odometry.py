# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the robot was when a frame or a scan was captured, by what its base says."""

from __future__ import annotations

from edgefusion.errors import RefusedError
from edgefusion.messages.to_odometry import Reckoning
from edgefusion.service.pose_track import PoseTrack
from edgefusion.types import Pose2D

CARRIED_NS = 200_000_000
"""So far beyond the newest report the robot is taken to go on as that says."""


class VisionOdometry:
    """Of one run of the base after the other: each counts from where it began."""

    def __init__(self) -> None:
        self._run, self._track = "", PoseTrack(CARRIED_NS)

    def report(self, run: str, reckoning: Reckoning) -> None:
        """What the base says; run: names this start of it."""
        if run != self._run:
            self._run, self._track = run, PoseTrack(CARRIED_NS)
        self._track.report(*reckoning)

    def at(self, stamp_ns: int) -> Pose2D | None:
        """In `odom`; None where it is not known."""
        try:
            return self._track.at(stamp_ns)
        except RefusedError:
            return None
