# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How robot and laser are, by all that they said since the last step, and whether the robot may be driven."""

from __future__ import annotations

import math
from typing import Tuple

from edgefusion.config import SafetyConfig
from edgefusion.navigation.safety import Action, judge_health
from edgefusion.service.base_inputs import Inputs
from edgefusion.service.failure_watch import FailureWatch, first_failure
from edgefusion.types import Health, Pose2D, Scan


class Readiness:
    """As of the last look. healths: of all components. scan: that may be driven by: none of a laser that is not well,
    or was not since the look before. failure: why the robot may not be driven, empty where it did not fail."""

    def __init__(self, safety: SafetyConfig, low_battery_v: float) -> None:
        self._safety = safety
        self._low_battery_v, self._battery_v = low_battery_v, math.inf
        self._robot, self._laser = FailureWatch(), FailureWatch()
        self.healths: Tuple[Health, ...] = ()
        self.scan: Scan | None = None
        self.failure = ""

    def look(self, inputs: Inputs) -> None:
        """At what came."""
        robot, laser = self._robot.look(inputs.robot), self._laser.look(inputs.laser)
        self.healths = (*robot, *laser, *inputs.healths)
        failure = first_failure(robot)
        self.failure = "" if failure is None else f"{failure.component}: {failure.reason}"
        self.scan = inputs.laser.newest if first_failure(laser) is None else None
        if inputs.robot.newest is not None:
            self._battery_v = inputs.robot.newest.state.battery_v

    def refusal(self, pose: Pose2D | None) -> str:
        """Why no goal is driven to; empty where they are. pose: where the robot is, None before it has said so."""
        findings = judge_health(self.healths, self._safety)
        reasons = [finding.reason for finding in findings if finding.action >= Action.STOP]
        if pose is None:
            reasons.append("robot: has not said yet where it is")
        if self._battery_v < self._low_battery_v:
            reasons.append(f"robot: the battery is low: {self._battery_v:.1f} V")
        return "; ".join(reasons)
