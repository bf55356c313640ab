# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer 3-DX: a differential drive that takes its time, and whose wheels may not do what they count."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.pose_history import PoseHistory
from edgefusion.types import STILL, Pose2D, Twist2D

_NS_PER_S = 1_000_000_000


@dataclass(frozen=True)
class BaseSpec:
    """Limits of the drive, and how its wheels err.

    A real P3-DX reports tops of 1.0 m/s, 360 deg/s, 2.0 m/s^2 and 300 deg/s^2 (its CONFIGpac) and can go a little
    faster than it reports; the accelerations here are gentle ones, and hold for braking, too.
    wheel_base_m: the effective one, which ARIA's DiffConvFactor of 0.0056 implies (2 / 0.0056 = 357 mm).
    slip_m: standard deviation of what a wheel slips over its first metre; it grows with the root of the way.
    left_drift_percent, right_drift_percent: how much farther than counted a wheel always goes. None of the three by
    default: odometry is the truth then.
    """

    max_speed_mps: float = 1.2
    max_yaw_rate_radps: float = math.radians(100)
    acceleration_mps2: float = 0.3
    yaw_acceleration_radps2: float = math.radians(100)
    wheel_base_m: float = 2 / 5.6
    slip_m: float = 0.0
    left_drift_percent: float = 0.0
    right_drift_percent: float = 0.0

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self)):
            value = getattr(self, name)
            if name.endswith("_percent"):
                if not -100 < value < math.inf:
                    raise RefusedError(f"{name}: expected a finite number above -100, got {value}")
            elif name == "slip_m":
                if not 0 <= value < math.inf:
                    raise RefusedError(f"{name}: expected a finite number of at least 0, got {value}")
            elif not 0 < value < math.inf:
                raise RefusedError(f"{name}: expected a finite number above 0, got {value}")


class SimBase:
    """Drives as commanded from a pose in the world. The same seed and the same steps lead to the same place.

    pose: where it truly is, in the world. odometry: where its wheels say it is, in `odom`, which begins where it
    started. twist: how fast its wheels say it is. stamp_ns: the time that its steps have led to.
    """

    def __init__(self, spec: BaseSpec | None = None, pose: Pose2D = STILL, seed: int = 0, stamp_ns: int = 0) -> None:
        self._spec = spec or BaseSpec()
        self._rng = np.random.default_rng(seed)
        self._target = Twist2D()
        self._history = PoseHistory()
        self._history.add(stamp_ns, pose)
        self.stamp_ns, self.pose = stamp_ns, pose
        self.odometry, self.twist = STILL, Twist2D()

    def command(self, twist: Twist2D) -> None:
        """The velocity to reach and keep, within the limits, in whole mm/s and deg/s as the wire carries it."""
        spec = self._spec
        v_mps = max(-spec.max_speed_mps, min(spec.max_speed_mps, twist.v_mps))
        w_radps = max(-spec.max_yaw_rate_radps, min(spec.max_yaw_rate_radps, twist.w_radps))
        self._target = Twist2D(round(v_mps * 1000) / 1000, math.radians(round(math.degrees(w_radps))))

    def step(self, dt_ns: int) -> None:
        """Drives on for some time. Raises RefusedError for none."""
        if dt_ns <= 0:
            raise RefusedError(f"dt_ns: expected more than 0, got {dt_ns}")
        spec, dt_s = self._spec, dt_ns / _NS_PER_S
        v_mps, way_m = _ramp(self.twist.v_mps, self._target.v_mps, spec.acceleration_mps2, dt_s)
        w_radps, turn = _ramp(self.twist.w_radps, self._target.w_radps, spec.yaw_acceleration_radps2, dt_s)
        self.twist = Twist2D(v_mps, w_radps)
        aside_m = turn * spec.wheel_base_m / 2
        left_m, right_m = way_m - aside_m, way_m + aside_m
        self.odometry = self._rolled(self.odometry, left_m, right_m)
        self.pose = self._rolled(
            self.pose, self._real(left_m, spec.left_drift_percent), self._real(right_m, spec.right_drift_percent)
        )
        self.stamp_ns += dt_ns
        self._history.add(self.stamp_ns, self.pose)

    def pose_at(self, stamp_ns: int) -> Pose2D:
        """The true pose at a time within the last second. Raises RefusedError for any other."""
        return self._history.at(stamp_ns)

    def _rolled(self, pose: Pose2D, left_m: float, right_m: float) -> Pose2D:
        """Where a pose gets to when the wheels roll so far: along an arc."""
        arc = Twist2D((left_m + right_m) / 2, (right_m - left_m) / self._spec.wheel_base_m)
        return pose.compose(arc.motion(1.0))

    def _real(self, counted_m: float, drift_percent: float) -> float:
        """How far a wheel really gets. Variances add up, so it does not matter in how many steps it gets there."""
        slipped_m = self._spec.slip_m * math.sqrt(abs(counted_m)) * self._rng.standard_normal()
        return counted_m * (1 + drift_percent / 100) + slipped_m


def _ramp(speed: float, target: float, acceleration: float, dt_s: float) -> tuple[float, float]:
    """The speed after some time of constant acceleration towards a target, and the way until then."""
    ramp_s = min(abs(target - speed) / acceleration, dt_s)
    reached = target if ramp_s < dt_s else speed + math.copysign(acceleration * dt_s, target - speed)
    return reached, (speed + reached) / 2 * ramp_s + reached * (dt_s - ramp_s)
