# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the robot is between its reports: the odometry, carried on with the velocity that the newest report says."""

from __future__ import annotations

from edgefusion.errors import RefusedError
from edgefusion.pose_history import PoseHistory
from edgefusion.types import Pose2D, Twist2D


class PoseTrack(PoseHistory):
    """carried_ns: for so long at most beyond the newest report."""

    def __init__(self, carried_ns: int) -> None:
        super().__init__()
        self._carried_ns = carried_ns
        self._newest: tuple[int, Pose2D, Twist2D] | None = None

    def report(self, stamp_ns: int, pose: Pose2D, twist: Twist2D) -> None:
        """The newest; one that is known already changes nothing."""
        if self._newest is None or stamp_ns > self._newest[0]:
            self.add(stamp_ns, pose)
            self._newest = stamp_ns, pose, twist

    def at(self, stamp_ns: int) -> Pose2D:
        """The pose at a time that the reports cover, or not long after. Raises RefusedError for any other."""
        if self._newest is None or stamp_ns <= self._newest[0]:
            return super().at(stamp_ns)
        newest_ns, pose, twist = self._newest
        if stamp_ns - newest_ns > self._carried_ns:
            raise RefusedError(f"stamp_ns: the newest report is of {newest_ns}, got {stamp_ns}")
        return pose.compose(twist.motion((stamp_ns - newest_ns) / 1e9))

    def now(self, now_ns: int) -> Pose2D | None:
        """The pose now, as far as it is known; None before the first report."""
        if self._newest is None:
            return None
        return self.at(min(now_ns, self._newest[0] + self._carried_ns))
