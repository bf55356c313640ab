# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives to a goal: where the field leads, by the control law, as far as the guard permits."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.drive_model import DriveModel
from edgefusion.navigation.errand import Errand, Now
from edgefusion.navigation.local_frame import LocalFrame
from edgefusion.navigation.progress import Progress
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import FARTHEST_M, Goal, Pose2D, Scan, Twist2D

_NS_PER_S = 1e9


class Navigator:
    """One robot's navigation. It is deterministic, and has no clock, thread or port: the same steps give the same
    velocities.

    What was seen is kept from goal to goal. After a pause in which the robot was driven by others it goes on with what
    it knew, and a jump of the odometry moves the goal, not what was seen.
    """

    def __init__(self, navigation: NavigationConfig, base: BaseConfig) -> None:
        self._navigation, self._base = navigation, base
        self._frame, self._drive = LocalFrame(base), DriveModel(base)
        self._surroundings = Surroundings(navigation, base)
        self._stamp_ns: int | None = None
        self._pose = Pose2D()
        self._errand: Errand | None = None
        self._answer = Twist2D()

    def step(
        self,
        stamp_ns: int,
        scan: Scan | None,
        pose: Pose2D,
        goal: Goal,
        rear_points_m: npt.ArrayLike | None = None,
        sent: Twist2D | None = None,
    ) -> Tuple[Twist2D, Progress]:
        """The velocity to drive with from now on, in what the wire carries, and how far the robot has got.

        Called 20 times a second. scan: the newest; it may be older than stamp_ns, and the same as the last time. pose:
        the odometry at stamp_ns, carried on to there by who reads it more seldom. goal: in `odom`; one that differs
        from the last step's takes its place. Once a goal has ended the answer to it stays: zero, and how it ended; the
        same goal again needs another id. rear_points_m [k, 2]: what a rear sonar sees now, in base_link. sent: what
        went to the robot after the last step, where that was not its answer.

        Raises RefusedError, before anything has changed, for a stamp that is not after the last one's, a pose farther
        than FARTHEST_M from the origin along an axis, and rear points that are not [k, 2] or farther than that. An
        empty list is none of them. Raises RefusedError, too, for a goal that jumps of the odometry have moved beyond
        all maps.
        """
        rear = self._checked(stamp_ns, pose, rear_points_m)
        held = sent == Twist2D() != self._answer
        if sent is not None:
            self._drive.sent(sent)
        errand = self._errand_for(goal)
        here = self._moved_to(stamp_ns, pose)
        target = self._frame.place(goal.pose)
        _expect_within(2 * FARTHEST_M, f"goal {goal.id}, where jumps of the odometry moved it", target)
        self._surroundings.stand(stamp_ns, here, target)
        if scan is not None:
            self._surroundings.see(scan, here)
        ahead = self._drive.ahead(stamp_ns, here)
        self._surroundings.look(stamp_ns + self._drive.delay_ns, ahead, here, rear)
        now = Now(stamp_ns, here, ahead, target, self._scan_age_s(stamp_ns), self._drive.stands, held)
        self._answer, progress = errand.step(now)
        self._drive.commanded(stamp_ns, self._answer)
        return self._answer, progress

    def way(self, length_m: float) -> npt.NDArray[np.float64]:
        """The way ahead as it is known now [k, 2], in `odom`; empty where there is none, or the field plans none."""
        if self._errand is None:
            return np.zeros((0, 2))
        return self._frame.in_odom(self._errand.way(self._pose, length_m))

    def seen_points(self) -> npt.NDArray[np.float64]:
        """All that was seen and has not faded [n, 2], in `odom`."""
        return self._frame.in_odom(self._surroundings.map.points())

    def _checked(self, stamp_ns: int, pose: Pose2D, rear_points_m: npt.ArrayLike | None) -> npt.NDArray[np.float64]:
        """The rear points [k, 2]. Raises RefusedError for what no step can be made of."""
        if self._stamp_ns is not None and stamp_ns <= self._stamp_ns:
            raise RefusedError(f"stamp_ns: expected more than {self._stamp_ns}, got {stamp_ns}")
        _expect_within(FARTHEST_M, "pose", pose)
        rear = np.zeros((0, 2)) if rear_points_m is None else np.asarray(rear_points_m, float)
        if rear.shape == (0,):
            rear = rear.reshape(0, 2)
        if rear.ndim != 2 or rear.shape[1] != 2:
            raise RefusedError(f"rear_points_m: expected shape [k, 2], got {list(rear.shape)}")
        beyond = rear[~(np.abs(rear) <= FARTHEST_M)]
        if len(beyond):
            raise RefusedError(f"rear_points_m: expected coordinates up to {FARTHEST_M:g} m, got {beyond[0]:g}")
        return rear

    def _scan_age_s(self, stamp_ns: int) -> float:
        """Of the newest scan on the map."""
        scan_ns = self._surroundings.scan_ns
        return math.inf if scan_ns is None else (stamp_ns - scan_ns) / _NS_PER_S

    def _errand_for(self, goal: Goal) -> Errand:
        if self._errand is None or self._errand.goal != goal:
            self._errand = Errand(goal, self._navigation, self._base, self._surroundings)
        return self._errand

    def _moved_to(self, stamp_ns: int, odometry: Pose2D) -> Pose2D:
        """Where the robot is now, in the local frame."""
        if self._stamp_ns is None:
            here = self._frame.enter(odometry, 0.0, Twist2D())
        else:
            dt_s = (stamp_ns - self._stamp_ns) / _NS_PER_S
            here = self._frame.enter(odometry, dt_s, self._drive.twist)
            self._drive.moved(self._stamp_ns, stamp_ns, here.relative_to(self._pose))
        self._stamp_ns, self._pose = stamp_ns, here
        return here


def _expect_within(most_m: float, name: str, pose: Pose2D) -> None:
    if max(abs(pose.x_m), abs(pose.y_m)) > most_m:
        raise RefusedError(f"{name}: expected coordinates up to {most_m:g} m, got {pose}")
