# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From a Pioneer's SIPs to its states, as long as one follows from the other, and to its health."""

from __future__ import annotations

from edgefusion.config.pioneer import PioneerConfig
from edgefusion.drivers.pioneer_factors import Factors
from edgefusion.drivers.pioneer_judgement import COMPONENT, Judgement
from edgefusion.drivers.pioneer_limits import Limits
from edgefusion.drivers.pioneer_odometry import Odometry
from edgefusion.drivers.pioneer_state import RobotState, robot_state
from edgefusion.drivers.sip_status import Status
from edgefusion.types import STILL, Health, HealthState, Pose2D, Twist2D

_STANDING_MPS, _STANDING_RADPS = 0.005, 0.02
_RESET_STATUSES = 3
"""SETO takes effect in one of the next SIPs."""


class Reports:
    """Of one session; pose: where the robot was at its beginning, in `odom`.

    state: the newest, None before the first. health: as of then. implausible: how many SIPs were left out, since they
    do not follow from those before.
    """

    def __init__(self, config: PioneerConfig, limits: Limits, factors: Factors, pose: Pose2D) -> None:
        self._factors = factors
        self._odometry = Odometry(factors, pose)
        self._judgement = Judgement(config, limits)
        self._resets_left = 0
        self.state: RobotState | None = None
        self.health = Health(COMPONENT, HealthState.STARTING, "no report yet")
        self.implausible = 0

    @property
    def pose(self) -> Pose2D:
        """The newest."""
        return self._odometry.pose

    @property
    def stands(self) -> bool:
        """Whether it says so; before the first state nobody knows."""
        twist = self.state.twist if self.state else None
        return twist is not None and abs(twist.v_mps) <= _STANDING_MPS and abs(twist.w_radps) <= _STANDING_RADPS

    def robot_heading(self, theta: float) -> float:
        """A heading in `odom` as the robot itself counts it [rad]."""
        return self._odometry.robot_heading(theta)

    def reset_pose(self) -> None:
        """It begins at STILL again; of a robot that stands, which was told so."""
        self._odometry.pose = STILL
        self._resets_left = _RESET_STATUSES

    def add(self, stamp_ns: int, status: Status, commanded: Twist2D | None) -> RobotState | None:
        """The state that a SIP reports; None where it does not follow from those before. commanded: as in `judge`."""
        if self.state is not None:
            stamp_ns = max(stamp_ns, self.state.stamp_ns + 1)  # two that were held up and came at once
        if self._resets_left:
            self._resets_left -= 1
            self._odometry.begin_anew()
        if not self._odometry.add(stamp_ns, status):
            self.implausible += 1
            return None
        self.state = robot_state(status, self._factors, self._odometry.pose, stamp_ns)
        self.health = self._judgement.judge(self.state, commanded)
        return self.state
