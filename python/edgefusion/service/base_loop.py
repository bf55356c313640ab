# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the base does twenty times a second: news of robot and laser in, a command out, by mission and safety gate.

It has no clock, thread or port. An outage of the laser it waits out, and drives on after some good scans. When the
robot itself failed, or may not be driven, its goals are given up, and it stays until there is a new one; that one is
refused for as long as the robot is not well.
"""

from __future__ import annotations

import math
from typing import Sequence

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.config import Config
from edgefusion.errors import RefusedError
from edgefusion.navigation.law import as_carried
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.safety import SafetyGate, Stamps
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.base_readiness import Readiness
from edgefusion.service.base_stops import Stops
from edgefusion.service.pose_track import PoseTrack
from edgefusion.types import Goal, Pose2D, Scan, Twist2D

WAY_M = 10.0
"""So much of the way ahead is told."""


class BaseLoop:
    """scan_age_limit_s: of the laser that is there; what the configuration allows is not exceeded either. pose: as of
    the last step."""

    def __init__(self, config: Config, scan_age_limit_s: float = math.inf) -> None:
        limit_s = min(config.safety.max_scan_age_s, config.navigation.max_scan_age_s, scan_age_limit_s)
        safety = msgspec.structs.replace(config.safety, max_scan_age_s=limit_s)
        navigation = msgspec.structs.replace(config.navigation, max_scan_age_s=limit_s)
        self._navigator = Navigator(navigation, config.base)
        self._mission = Mission(config.mission, self._navigator)
        self._gate = SafetyGate(safety, config.base)
        self._stops = Stops(self._mission, self._gate)
        self._ready = Readiness(safety, config.robot.low_battery_v)
        self._poses = PoseTrack(round(safety.max_odometry_age_s * 1e9))
        self._scan_ns: int | None = None  # of the newest that was handed out
        self._sent = Twist2D()
        self._motors_wanted = False
        self._way_every_ns, self._way_ns = round(1e9 / config.bus.state_hz), 0
        self.pose: Pose2D | None = None

    @property
    def over_limit(self) -> int:
        """In how many steps the command was faster than the base may go."""
        return self._gate.over_limit

    @property
    def ordered_stop(self) -> str:
        """Why an operator has stopped it; empty where none has, or they resumed."""
        return self._stops.ordered

    def goto(self, goals: Sequence[Goal]) -> None:
        """Drive to these goals, in this order, instead of to those that are left. What a failure of the robot has
        stopped is left by that; what an operator has stopped is not until `resume`.

        Raises RefusedError, and changes nothing, while the robot may not be driven, and as Mission.goto.
        """
        refusal = self._ready.refusal(self.pose)
        if refusal:
            raise RefusedError(f"goal: refused: {refusal}")
        self._mission.goto(goals)
        if self._stops.held:
            self._stops.leave()

    def cancel(self) -> None:
        """Give up the goals that are left, and stand."""
        self._mission.cancel()

    def stop(self, reason: str) -> None:
        """Stand still, whatever is under way, until `resume`. Raises RefusedError for no reason."""
        self._stops.stop(reason)

    def pause(self, reason: str) -> None:
        """The mission stands until `resume`: somebody else drives. An inspection ends as by a stop."""
        self._stops.pause(reason)

    def inspect(self, interest: Sequence[str]) -> None:
        """What to inspect from now on, labels or groups; none: nothing."""
        self._mission.inspect(interest)

    def resume(self) -> None:
        """Leave the stop, whoever caused it, for the goals that are left; motors that are off are to be switched on.

        What still is not well stops it again. Raises RefusedError where nothing was stopped.
        """
        self._stops.leave()
        self._motors_wanted = True

    def step(self, now_ns: int, inputs: Inputs) -> Outputs:
        """One cycle. Raises RefusedError for a time that is not after the last step's."""
        self._ready.look(inputs)
        if self._ready.failure:
            self._stops.hold(self._ready.failure)
        scan = self._ready.scan
        pose = self.pose = self._pose(now_ns, inputs)
        mission = self._mission_step(now_ns, scan, pose, inputs)
        report = inputs.robot.newest
        stamps = Stamps(
            None if scan is None else scan.stamp_ns,
            None if report is None else report.state.stamp_ns,
            inputs.detections_ns,
            now_ns,
        )
        decision = self._gate.step(now_ns, self._ready.healths, stamps, _wanted(mission, inputs))
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
            self._ready.healths,
            None if report is None else report.state,
            inputs.twist is not None,
            self._way_m(now_ns, mission),
        )

    def _pose(self, now_ns: int, inputs: Inputs) -> Pose2D | None:
        if inputs.robot.newest is not None:
            state = inputs.robot.newest.state
            self._poses.report(state.stamp_ns, state.odometry, state.twist)
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


def _wanted(mission: MissionStep, inputs: Inputs) -> Twist2D:
    """What the gate is asked for."""
    return mission.twist if inputs.twist is None else inputs.twist
