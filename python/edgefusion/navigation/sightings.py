# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections arrive late: each is placed in `odom` by where the robot was when its picture was taken."""

from __future__ import annotations

import math
from typing import Sequence

from edgefusion.config import MissionConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.objects import KnownObjects, Point, is_of_interest
from edgefusion.navigation.rest import REST_NS, is_at_rest
from edgefusion.pose_history import PoseHistory
from edgefusion.types import Detection, Pose2D


class Sightings:
    """Remembers where the robot was, and what of interest it saw from there.

    unplaced: how many detections were dropped, since they are of a time of which no pose is known, or of no place.
    """

    def __init__(self, settings: MissionConfig) -> None:
        self._settings = settings
        self._poses = PoseHistory(max(round(settings.max_detection_age_s * 1e9), REST_NS))
        # A frame confirms others no older than the window, and it may itself be as old as the poses go back.
        self._useful_ns = round((settings.max_detection_age_s + settings.confirm_s) * 1e9)
        self.objects = KnownObjects(settings)
        self.unplaced = 0

    def take_interest(self, settings: MissionConfig) -> None:
        """In something else from now on; what was due for inspection no longer is."""
        self._settings = settings
        self.objects.none_due()

    def add_pose(self, stamp_ns: int, pose: Pose2D) -> None:
        """Raises RefusedError for a stamp that is not after the last one."""
        self._poses.add(stamp_ns, pose)
        self.objects.forget_unconfirmed(stamp_ns - self._useful_ns)

    def add(self, detections: Sequence[Detection], inspecting: bool) -> None:
        """What arrived. inspecting: what is confirmed and not yet visited is due for inspection now."""
        for detection in detections:
            if not is_of_interest(detection, self._settings):
                continue
            point = self._placed(detection)
            if point is None:
                self.unplaced += 1
                continue
            found = self.objects.add(detection, point)
            found.due |= inspecting and found.confirmed

    def is_at_rest(self, stamp_ns: int, pose: Pose2D) -> bool:
        """Whether the robot is, at the time of the last pose."""
        return is_at_rest(stamp_ns, pose, self._poses)

    def _placed(self, detection: Detection) -> Point | None:
        """Its nearest surface, in `odom`."""
        if not all(map(math.isfinite, detection.position_m)):
            return None
        try:
            point = self._poses.at(detection.stamp_ns).compose(Pose2D(*detection.position_m))
        except RefusedError:
            return None
        return point.x_m, point.y_m
