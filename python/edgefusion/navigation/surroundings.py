# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is around the robot: scans, placed with the odometry at the time of each beam, on the map of what was seen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from edgefusion._core import Footprint, Guard, ObstacleMap
from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.navigation.drive_model import Motion
from edgefusion.navigation.mixed_pixels import without_mixed
from edgefusion.navigation.movers import Movers
from edgefusion.pose_history import PoseHistory
from edgefusion.types import Pose2D, Scan

Floats = npt.NDArray[np.float64]

_INSET_M = 0.02
"""What seems to be so deep inside the hull where the robot stands has gone, or never was there."""

BLIND_SHARE = 0.9
"""A scan of which more beams say nothing is none."""

_FARTHEST_M, _SPARE_S, _NS_PER_S = 1e6, 0.2, 1e9
_EDGE_NS = 60_000_000
"""A beam may be measured so much before the first pose, or after the newest, and is placed with that."""


class Surroundings:
    """map, in the local frame; guard, which has looked at what is near; points [n, 2]: the newest scan's, there;
    rear_m [k, 2]: the rear sonar's."""

    def __init__(self, navigation: NavigationConfig, base: BaseConfig) -> None:
        self._laser = Pose2D(*base.laser_pose)
        self._history = PoseHistory(round((navigation.max_scan_age_s + 0.5) * _NS_PER_S))
        self.scan_ns: int | None = None
        self.footprint = Footprint(base.footprint_m)
        self.map = ObstacleMap(navigation.cell_m)
        ramps = base.acceleration_mps2, base.yaw_acceleration_radps2
        self.guard = Guard(self.footprint, *ramps)
        braking_m = base.max_speed_mps**2 / (2 * base.acceleration_mps2)
        held_m = base.max_speed_mps * (navigation.max_scan_age_s + _SPARE_S)
        self._reach_m = self.footprint.circumscribed_m + navigation.margin_m + held_m + braking_m
        self._movers = Movers()
        self.points: Floats = np.zeros((0, 2))
        self.rear_m: Floats = np.zeros((0, 2))

    def stand(self, stamp_ns: int, pose: Pose2D, goal: Pose2D) -> None:
        """The robot is here now, and on its way there."""
        self._history.add(stamp_ns, pose)
        self.map.cover(pose.x_m, pose.y_m, goal.x_m, goal.y_m)
        self.map.stand(self.footprint, row(pose), _INSET_M)

    def see(self, scan: Scan, pose: Pose2D) -> None:
        """Puts a scan on the map, for a robot that is here by now.

        Left out are a scan that is there already, one of a time when the pose was not known, and one that says hardly
        anything: of a laser that is covered or dazzled.
        """
        if self.scan_ns is not None and scan.stamp_ns <= self.scan_ns:
            return
        poses = self._laser_poses(scan)
        if poses is None or np.isnan(scan.ranges_m).mean() > BLIND_SHARE:
            return
        # Nearer than it can measure is as near as that. Neighbours are those in the world: a robot that turns mixes up
        # the beams of interlaced mirror turns.
        ranges_m = np.where(scan.ranges_m < scan.range_min_m, np.float32(scan.range_min_m), scan.ranges_m)
        scan = replace(scan, ranges_m=without_mixed(ranges_m, poses[:, 2] + scan.angles))
        self.scan_ns = scan.stamp_ns
        beams = scan.ranges_m, scan.angle_min, scan.angle_increment
        self.map.insert(poses, *beams, scan.range_min_m, min(scan.range_max_m, _FARTHEST_M), scan.stamp_ns)
        self.map.stand(self.footprint, row(pose), _INSET_M)
        self.points = _ends(poses, scan)
        self._movers.see(scan, self.points, Pose2D(*poses[len(poses) // 2]), self.map)

    def touched(self, pose: Pose2D) -> bool:
        """Whether the newest scan sees something inside the hull of a robot here."""
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        x, y = ((self.points - (pose.x_m, pose.y_m)) @ np.array([[c, -s], [s, c]])).T
        near = np.hypot(x, y) < self.footprint.circumscribed_m
        return any(self.footprint.gap(a, b) < -_INSET_M for a, b in zip(x[near], y[near]))

    def look(self, stamp_ns: int, ahead: Motion, here: Pose2D, rear_m: Floats) -> None:
        """The guard looks about where and when the next command takes effect. rear_m [k, 2]: what the rear sonar sees,
        in base_link of the robot here; it is not remembered."""
        self.rear_m = _placed(rear_m, here)
        standing = np.hstack([self.rear_m, np.zeros_like(self.rear_m)])
        moving = np.concatenate([standing, self._movers.at(stamp_ns)])
        self.guard.look(self.map, ahead[0], ahead[1], self._reach_m, moving)

    def _laser_poses(self, scan: Scan) -> Floats | None:
        """Of every beam, (x, y, theta); the robot is taken to move evenly from the first to the last of them."""
        dt_ns = np.zeros(len(scan.ranges_m), np.int64) if scan.beam_dt_ns is None else scan.beam_dt_ns
        if not len(dt_ns):
            return None
        first_ns, last_ns = int(dt_ns.min()), int(dt_ns.max())
        begin, end = (self._history.near(scan.stamp_ns + ns, _EDGE_NS) for ns in (first_ns, last_ns))
        if begin is None or end is None:
            return None
        share = (dt_ns - first_ns) / max(last_ns - first_ns, 1)
        a, b = begin.compose(self._laser), end.compose(self._laser)
        turn = math.remainder(b.theta - a.theta, 2 * math.pi)
        change = np.array([b.x_m - a.x_m, b.y_m - a.y_m, turn])
        return np.asarray(np.array([a.x_m, a.y_m, a.theta]) + share[:, None] * change)


def _ends(poses: Floats, scan: Scan) -> Floats:
    """Where the beams ended that met something [n, 2]."""
    hit = np.isfinite(scan.ranges_m)
    angles = poses[hit, 2] + scan.angles[hit]
    return np.asarray(poses[hit, :2] + scan.ranges_m[hit, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def _placed(points_m: Floats, pose: Pose2D) -> Floats:
    """Points of base_link in the local frame."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return np.asarray(points_m @ np.array([[c, s], [-s, c]]) + (pose.x_m, pose.y_m))


def row(pose: Pose2D) -> tuple[float, float, float]:
    """As the core takes it."""
    return pose.x_m, pose.y_m, pose.theta
