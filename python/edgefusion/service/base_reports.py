# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the base's loop did, as the reports that go over the bus. Pure."""

from __future__ import annotations

import math
from typing import List

import numpy as np
import numpy.typing as npt

from edgefusion.messages.mission_report import InspectionReport, MissionReport, Place, Pose
from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.navigation.safety import Action, Decision
from edgefusion.service.base_inputs import Outputs
from edgefusion.types import Health, HealthState, Pose2D

COMPONENT = "base"


def mission_report(outputs: Outputs) -> MissionReport:
    """Also before the robot has reported: it may be stopped."""
    step = outputs.mission
    return MissionReport(
        stamp_ns=outputs.stamp_ns,
        state=step.state.value,
        reason=step.reason,
        goal_id=step.goal_id,
        goal_m=None if step.goal is None else _place(step.goal.pose),
        pose=None if outputs.pose is None else _pose(outputs.pose),
        way_left_m=None if step.progress is None else _finite(step.progress.way_left_m),
        clearance_m=None if step.progress is None else _finite(step.progress.clearance_m),
        paused=outputs.paused,
        note=_note(outputs),
        result=None if step.result is None else inspection_report(step.result),
    )


def inspection_report(result: InspectionResult) -> InspectionReport:
    """How an inspection ended."""
    return InspectionReport(
        id=result.id,
        label=result.label,
        group=result.group,
        score=result.detection.score,
        distance_m=result.detection.distance_m,
        place_m=result.place_m,
        pose=_pose(result.pose),
        begun_ns=result.begun_ns,
        stood_ns=result.stood_ns,
        ended_ns=result.ended_ns,
        picture_ns=None if result.picture is None else result.picture.stamp_ns,
        reason=result.reason,
        note=result.note,
    )


def base_health(outputs: Outputs) -> Health:
    """Of the base itself: degraded while something holds or slows the robot, or it drives on without what failed."""
    failed = [each for each in outputs.healths if each.state is HealthState.FAILED]
    without = [f"drives on without {each.component}: {each.reason}" for each in failed]
    reason = _held(outputs.decision) or "; ".join(without)
    return Health(COMPONENT, HealthState.DEGRADED if reason else HealthState.OK, reason)


def way_poses(way_m: npt.NDArray[np.float64]) -> List[Pose2D]:
    """Of points on the way [k, 2], each looking to the next."""
    if len(way_m) < 2:
        return []
    steps = np.diff(way_m, axis=0)
    headings = np.arctan2(steps[:, 1], steps[:, 0]).tolist()
    return [Pose2D(x, y, theta) for (x, y), theta in zip(way_m.tolist(), [*headings, headings[-1]])]


def _held(decision: Decision) -> str:
    return "; ".join(finding.reason for finding in decision.findings if finding.action > Action.RUN)


def _note(outputs: Outputs) -> str:
    """What the robot is doing, and what keeps it from that."""
    held = _held(outputs.decision) if _wants_to_move(outputs.mission) else ""
    return "; ".join(text for text in (outputs.mission.note, held) if text)


def _wants_to_move(step: MissionStep) -> bool:
    return step.state in (MissionState.DRIVING, MissionState.INSPECTING)


def _place(pose: Pose2D) -> Place:
    return pose.x_m, pose.y_m


def _pose(pose: Pose2D) -> Pose:
    return pose.x_m, pose.y_m, pose.theta


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
