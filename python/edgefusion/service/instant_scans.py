# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Scans as the bus has them: all beams as if measured at the stamp, by where the robot says that it was."""

from __future__ import annotations

from edgefusion.drivers.lms2xx_deskew import deskewed
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.errors import RefusedError
from edgefusion.messages.transform import Matrix
from edgefusion.service.pose_track import PoseTrack
from edgefusion.types import Scan

CARRIED_NS = 250_000_000
"""So far beyond its newest report the robot is taken to go on as that says: 2.5 of a Pioneer's cycles."""


class InstantScans:
    """T_base_laser [4, 4]: laser coordinates into those of base_link. For one thread."""

    def __init__(self, T_base_laser: Matrix) -> None:
        self._T_base_laser, self._poses = T_base_laser, PoseTrack(CARRIED_NS)

    def reported(self, state: RobotState) -> None:
        """What the robot said; also again."""
        self._poses.report(state.stamp_ns, state.odometry, state.twist)

    def of(self, scan: Scan) -> Scan | None:
        """None where nobody knows how the robot moved meanwhile."""
        try:
            return deskewed(scan, self._poses, self._T_base_laser)
        except RefusedError:
            return None
