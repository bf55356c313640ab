# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the base does twenty times a second: news of robot and laser in, a command out, by mission and safety gate.

It has no clock, thread or port. An outage of the laser it waits out, and drives on after some good scans. When the
robot itself failed, or may not be driven, its goals are given up, and it stays until there is a new one; that one is
refused for as long as the robot is not well.
"""

from __future__ import annotations

import math
from typing import Sequence, Tuple

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.config import Config
from edgefusion.errors import RefusedError
from edgefusion.navigation.law import as_carried
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.safety import Action, SafetyGate, Stamps, judge_health
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.failure_watch import FailureWatch, first_failure
from edgefusion.service.pose_track import PoseTrack
from edgefusion.types import Goal, Health, Pose2D, Scan, Twist2D

_UNDER_WAY = (MissionState.DRIVING, MissionState.INSPECTING)

WAY_M = 10.0
"""So much of the way ahead is told."""


class BaseLoop:
    """scan_age_limit_s: of the laser that is there; what the configuration allows is not exceeded either. pose: as of
    the last step."""

    def __init__(self, config: Config, scan_age_limit_s: float = math.inf) -> None:
        limit_s = min(config.safety.max_scan_age_s, config.navigation.max_scan_age_s, scan_age_limit_s)
        self._safety = msgspec.structs.replace(config.safety, max_scan_age_s=limit_s)
        navigation = msgspec.structs.replace(config.navigation, max_scan_age_s=limit_s)
        self._navigator = Navigator(navigation, config.base)
        self._mission = Mission(config.mission, self._navigator)
        self._gate = SafetyGate(self._safety, config.base)
        self._poses = PoseTrack(round(self._safety.max_odometry_age_s * 1e9))
        self._low_battery_v, self._battery_v = config.robot.low_battery_v, math.inf
        self._robot, self._laser = FailureWatch(), FailureWatch()
        self._healths: Tuple[Health, ...] = ()
        self._scan_ns: int | None = None  # of the newest that was handed out
        self._sent = Twist2D()
        self._held = False  # since the robot failed, and not by an operator
        self._paused = False  # since somebody else drives
        self._motors_wanted = False
        self._way_every_ns, self._way_ns = round(1e9 / config.bus.state_hz), 0
        self.pose: Pose2D | None = None

    def goto(self, goals: Sequence[Goal]) -> None:
        """Drive to these goals, in this order, instead of to those that are left. What a failure of the robot has
        stopped is left by that; what an operator has stopped is not until `resume`.

        Raises RefusedError, and changes nothing, while the robot may not be driven, and as Mission.goto.
        """
        refusal = self._refusal()
        if refusal:
            raise RefusedError(f"goal: refused: {refusal}")
        self._mission.goto(goals)
        if self._held:
            self._leave()

    def cancel(self) -> None:
        """Give up the goals that are left, and stand."""
        self._mission.cancel()

    def stop(self, reason: str) -> None:
        """Stand still, whatever is under way, until `resume`. Raises RefusedError for no reason."""
        if self._paused and reason:
            self._mission.resume()  # so that its reason is the worse one
        self._paused = False
        self._mission.stop(reason)
        self._gate.stop(reason)
        self._held = False

    def pause(self, reason: str) -> None:
        """The mission stands until `resume`: somebody else drives. An inspection ends as by a stop."""
        if self._mission.state is not MissionState.STOPPED:
            self._mission.stop(reason)
            self._paused = True

    def inspect(self, interest: Sequence[str]) -> None:
        """What to inspect from now on, labels or groups; none: nothing."""
        self._mission.inspect(interest)

    def resume(self) -> None:
        """Leave the stop, whoever caused it, for the goals that are left; motors that are off are to be switched on.

        What still is not well stops it again. Raises RefusedError where nothing was stopped.
        """
        self._leave()
        self._motors_wanted = True

    def step(self, now_ns: int, inputs: Inputs) -> Outputs:
        """One cycle. Raises RefusedError for a time that is not after the last step's."""
        scan = self._looked_at(inputs)
        pose = self.pose = self._pose(now_ns, inputs)
        mission = self._mission_step(now_ns, scan, pose, inputs)
        report = inputs.robot.newest
        stamps = Stamps(
            None if scan is None else scan.stamp_ns,
            None if report is None else report.state.stamp_ns,
            inputs.detections_ns,
            now_ns,
        )
        decision = self._gate.step(now_ns, self._healths, stamps, _wanted(mission, inputs))
        self._sent = as_carried(decision.twist)  # slowing gives fractions
        return Outputs(
            now_ns,
            self._sent,
            None if report is None else report.session,
            self._motors_to_enable(inputs),
            pose,
            mission,
            decision,
            self._new(scan),
            self._healths,
            None if report is None else report.state,
            inputs.twist is not None,
            self._way_m(now_ns, mission),
        )

    def _leave(self) -> None:
        """The stop, whether it is the mission's and the gate's or the gate's alone."""
        if self._mission.state is MissionState.STOPPED or not self._held:
            self._mission.resume()
        self._gate.resume()
        self._held = self._paused = False

    def _looked_at(self, inputs: Inputs) -> Scan | None:
        """Judges the devices, and gives the scan that may be driven by: none of a laser that is not well, or was not
        since the last step."""
        robot, laser = self._robot.look(inputs.robot), self._laser.look(inputs.laser)
        self._healths = (*robot, *laser, *inputs.healths)
        failure = first_failure(robot)
        if failure is not None:
            self._hold(f"{failure.component}: {failure.reason}")
        return None if first_failure(laser) is not None else inputs.laser.newest

    def _hold(self, reason: str) -> None:
        """The robot failed: until there is a new goal, or an operator's leave where an operator has stopped it."""
        if self._mission.state is not MissionState.STOPPED:
            self._held = True
            if self._mission.state in _UNDER_WAY:
                self._mission.stop(reason)
        if self._mission.state is MissionState.STOPPED:
            self._mission.cancel()

    def _pose(self, now_ns: int, inputs: Inputs) -> Pose2D | None:
        if inputs.robot.newest is not None:
            state = inputs.robot.newest.state
            self._poses.report(state.stamp_ns, state.odometry, state.twist)
            self._battery_v = state.battery_v
        return self._poses.now(now_ns)

    def _mission_step(self, now_ns: int, scan: Scan | None, pose: Pose2D | None, inputs: Inputs) -> MissionStep:
        if pose is None:  # it may have been stopped already
            return MissionStep(Twist2D(), self._mission.state, self._mission.reason)
        report = inputs.robot.newest
        rear_points_m = None if report is None else report.rear_points_m
        return self._mission.step(
            now_ns, scan, pose, inputs.detections, inputs.pictures, rear_points_m, sent=self._sent
        )

    def _motors_to_enable(self, inputs: Inputs) -> bool:
        wanted, self._motors_wanted = self._motors_wanted, False
        return wanted and inputs.robot.newest is not None and not inputs.robot.newest.state.motors_enabled

    def _new(self, scan: Scan | None) -> Scan | None:
        if scan is None or scan.stamp_ns == self._scan_ns:
            return None
        self._scan_ns = scan.stamp_ns
        return scan

    def _way_m(self, now_ns: int, mission: MissionStep) -> npt.NDArray[np.float64] | None:
        if self.pose is None or now_ns - self._way_ns < self._way_every_ns:
            return None
        self._way_ns = now_ns
        drives = mission.state is MissionState.DRIVING
        return self._navigator.way(WAY_M) if drives else np.zeros((0, 2))

    def _refusal(self) -> str:
        """Why no goal is driven to; empty where they are."""
        findings = judge_health(self._healths, self._safety)
        reasons = [finding.reason for finding in findings if finding.action >= Action.STOP]
        if self.pose is None:
            reasons.append("robot: has not said yet where it is")
        if self._battery_v < self._low_battery_v:
            reasons.append(f"robot: the battery is low: {self._battery_v:.1f} V")
        return "; ".join(reasons)


def _wanted(mission: MissionStep, inputs: Inputs) -> Twist2D:
    """What the gate is asked for."""
    return mission.twist if inputs.twist is None else inputs.twist
