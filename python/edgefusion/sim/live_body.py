# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base among walls and things: where its hull meets one it stalls, its bumpers feel it, its sonars hear it."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

import numpy as np
import numpy.typing as npt

from edgefusion._core import raycast
from edgefusion.drivers.pioneer_sonar import RING
from edgefusion.sim.body import Pressed
from edgefusion.sim.hull import Bounded, Hull
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.types import Pose2D, Twist2D

STEP_NS = 10_000_000
"""The base is integrated, and the contact checked, in steps of this length."""

_STALLS_NS = 200_000_000
_WATCHED_M, _APART_M = 0.05, 0.01
_SONAR_M, _SONAR_HALF, _SONAR_BEAMS = 5.0, math.radians(12), 9
_BUMPERS = 5
_FRONT = math.radians(100)
_STILL = (False, False)
_UNTOUCHED: Tuple[Pressed, Pressed] = ((False,) * _BUMPERS, (False,) * _BUMPERS)


class LiveBody:
    """A Body whose time goes on with step_to(). corners_m: its hull, in base_link."""

    def __init__(
        self, spec: BaseSpec, start: Pose2D, walls: Bounded, corners_m: Sequence[Tuple[float, float]], now_ns: int
    ) -> None:
        self._base = SimBase(spec, start, stamp_ns=now_ns)
        self._hull, self._walls = Hull(corners_m), walls
        self._edge = _edge_of(corners_m)
        self._commanded = Twist2D()
        self._blocked_ns = -_STALLS_NS
        self._touched = _UNTOUCHED

    @property
    def odometry(self) -> Pose2D:
        """Where its wheels have brought it."""
        return self._base.odometry

    @property
    def pose(self) -> Pose2D:
        """Where it really is, in the world."""
        return self._base.pose

    @property
    def twist(self) -> Twist2D:
        """How fast its wheels are."""
        return self._base.twist

    @property
    def stamp_ns(self) -> int:
        """Now."""
        return self._base.stamp_ns

    def pose_at(self, stamp_ns: int) -> Pose2D:
        """Where it really was, within the last second. Raises RefusedError for any other time."""
        return self._base.pose_at(stamp_ns)

    @property
    def stalled(self) -> Tuple[bool, bool]:
        """Both wheels while something keeps the hull from moving on."""
        stalls = self._base.stamp_ns - self._blocked_ns < _STALLS_NS and self._commanded != Twist2D()
        return (True, True) if stalls else _STILL

    @property
    def bumpers(self) -> Tuple[Pressed, Pressed]:
        """Of the side that touches."""
        return self._touched if self._base.stamp_ns - self._blocked_ns < _STALLS_NS else _UNTOUCHED

    def command(self, twist: Twist2D) -> None:
        """The velocity to reach and keep."""
        self._commanded = twist
        self._base.command(twist)

    def halt(self) -> None:
        """Stands at once."""
        self.command(Twist2D())
        self._base.twist = Twist2D()

    def sonar_m(self, number: int) -> float:
        """The nearest of what its cone meets, within 5 m."""
        place = RING[number]
        at = self.pose.compose(Pose2D(place.x_m, place.y_m, place.theta))
        ranges_m, _ = raycast(
            self._walls.segments,
            [at.x_m, at.y_m, at.theta],
            -_SONAR_HALF,
            2 * _SONAR_HALF / (_SONAR_BEAMS - 1),
            _SONAR_BEAMS,
            _SONAR_M,
        )
        return float(np.min(ranges_m))

    def step_to(self, now_ns: int) -> None:
        """Lets the time pass until then."""
        while self._base.stamp_ns < now_ns:
            self._step(min(STEP_NS, now_ns - self._base.stamp_ns))

    def _step(self, dt_ns: int) -> None:
        base = self._base
        before, counted = base.pose, base.odometry
        base.step(dt_ns)
        if base.pose == before or self._hull.clearance_m(base.pose, self._walls, _WATCHED_M) > 0:
            return
        self._touched = self._feel(base.pose)
        self._blocked_ns = base.stamp_ns
        base.pose, base.odometry, base.twist = before, counted, Twist2D()

    def _feel(self, pose: Pose2D) -> Tuple[Pressed, Pressed]:
        """Which bumper is nearest to what the hull has met."""
        x_m, y_m = self._contact(pose)
        bearing = math.atan2(y_m, x_m)
        if abs(bearing) < _FRONT:
            return _pressed((_FRONT - bearing) / (2 * _FRONT)), _UNTOUCHED[1]
        behind = math.remainder(bearing - math.pi, 2 * math.pi)  # from the right, over the back, to the left
        half = math.pi - _FRONT
        return _UNTOUCHED[0], _pressed((half - behind) / (2 * half))

    def _contact(self, pose: Pose2D) -> npt.NDArray[np.float64]:
        """The point of the hull's edge that is nearest to a wall, in base_link."""
        cosine, sine = math.cos(pose.theta), math.sin(pose.theta)
        edge = self._edge @ np.array([[cosine, sine], [-sine, cosine]]) + (pose.x_m, pose.y_m)
        starts, ways = self._walls.segments[:, :2], self._walls.segments[:, 2:] - self._walls.segments[:, :2]
        apart = edge[:, None] - starts
        shares = (apart * ways).sum(axis=2) / np.maximum((ways * ways).sum(axis=1), 1e-12)
        off = apart - np.clip(shares, 0.0, 1.0)[:, :, None] * ways
        nearest: npt.NDArray[np.float64] = self._edge[np.hypot(off[:, :, 0], off[:, :, 1]).min(axis=1).argmin()]
        return nearest


def _edge_of(corners_m: Sequence[Tuple[float, float]]) -> npt.NDArray[np.float64]:
    """Points along the hull, a centimetre apart or so, float64[k, 2]."""
    corners = np.asarray(corners_m, float)
    sides = zip(corners, np.roll(corners, -1, axis=0))
    return np.concatenate([np.linspace(a, b, 2 + int(np.hypot(*(b - a)) / _APART_M)) for a, b in sides])


def _pressed(share: float) -> Pressed:
    number = min(_BUMPERS - 1, max(0, int(share * _BUMPERS)))
    return tuple(i == number for i in range(_BUMPERS))
