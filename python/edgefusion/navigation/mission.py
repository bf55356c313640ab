# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The mission: drive to the goals, and inspect every object of interest that comes into view, once."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Protocol, Sequence

import msgspec
import numpy.typing as npt

from edgefusion.config import MissionConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.inspection import Inspection
from edgefusion.navigation.inspection_result import InspectionResult, PictureAnswer, PictureRequest
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.navigation.progress import Progress, State
from edgefusion.navigation.sightings import Sightings
from edgefusion.types import Detection, Goal, Pose2D, Scan, Twist2D

BRAKING_WAY_M = 5.0
"""Told to stand, the robot is where it shall be as far as it may roll: the navigator has nothing to drive back to."""


class Navigator(Protocol):
    """Drives to one goal; another goal.id than the last call's begins a new one."""

    def step(
        self,
        stamp_ns: int,
        scan: Scan | None,
        pose: Pose2D,
        goal: Goal,
        rear_points_m: npt.ArrayLike | None,
        sent: Twist2D | None,
    ) -> tuple[Twist2D, Progress]: ...


class Mission:
    """Idle > Driving > Inspecting > Driving > Arrived | Blocked | Stopped. It has no clock: steps tell it the time.

    state, reason: as in MissionStep. refused_answers: how many there were that nobody waits for, or no longer.
    """

    def __init__(self, settings: MissionConfig, navigator: Navigator) -> None:
        self._settings, self._navigator = settings, navigator
        self._sightings = Sightings(settings)
        self._goals: list[Goal] = []
        self._lists = 0  # of goals, so far
        self._stamp_ns = 0  # of the last step
        self._for_navigator: tuple[npt.ArrayLike | None, Twist2D | None] = (None, None)  # of this step
        self._there_ns: int | None = None  # since when it is at the last goal
        self._inspection: Inspection | None = None
        self._inspections = 0
        self._halt: Goal | None = None  # where it is told to stand
        self._result: InspectionResult | None = None  # to be answered by the next step
        self.state, self.reason = MissionState.IDLE, ""
        self.refused_answers = 0

    @property
    def unplaced_detections(self) -> int:
        """How many were dropped, since of the time when they were made no pose is known."""
        return self._sightings.unplaced

    def goto(self, goals: Sequence[Goal]) -> None:
        """Drive to these goals, in this order, instead of to those that are left.

        An inspection under way is finished first: cut short, it would only begin again. A mission that is stopped
        stays so until `resume`. Raises RefusedError, and changes nothing, for no goal and for an id that comes twice.
        """
        ids = [goal.id for goal in goals]
        if not ids:
            raise RefusedError("goals: expected at least one, got none")
        if len(set(ids)) < len(ids):
            raise RefusedError(f"goals: expected a different id for each, got {', '.join(ids)}")
        self._goals, self._there_ns = list(goals), None
        self._lists += 1
        if self.state not in (MissionState.INSPECTING, MissionState.STOPPED):
            self._become(MissionState.DRIVING)

    def stop(self, reason: str) -> None:
        """Stand still, whatever is under way, until `resume`. While it is stopped, the first reason stays.

        An inspection ends; its object is inspected again when it is sighted again, unless there is a picture of it.
        Raises RefusedError for no reason.
        """
        if not reason:
            raise RefusedError("reason: expected why to stop, got nothing")
        if self.state is MissionState.STOPPED:
            return
        if self._inspection is not None:
            self._end_inspection(self._inspection, f"stopped: {reason}")
        self._sightings.objects.none_due()
        self._become(MissionState.STOPPED, reason)

    def cancel(self) -> None:
        """Give up the goals that are left, and an inspection under way. A mission that is stopped stays so."""
        if self._inspection is not None:
            self._end_inspection(self._inspection, "cancelled")
        self._goals.clear()
        if self.state is not MissionState.STOPPED:
            self._become(MissionState.IDLE)

    def inspect(self, interest: Sequence[str]) -> None:
        """Inspect these from now on, labels or groups, instead of what was of interest; one under way is finished."""
        self._settings = msgspec.structs.replace(self._settings, interest=tuple(interest))
        self._sightings.take_interest(self._settings)

    def resume(self) -> None:
        """Leave the stop: drive to the goals that are left, or be idle. Raises RefusedError unless it is stopped."""
        if self.state is not MissionState.STOPPED:
            raise RefusedError(f"resume: expected a mission that is stopped, got one that is {self.state.value}")
        self._become(MissionState.DRIVING if self._goals else MissionState.IDLE)

    def step(
        self,
        stamp_ns: int,
        scan: Scan | None,
        pose: Pose2D,
        detections: Sequence[Detection] = (),
        answers: Sequence[PictureAnswer] = (),
        rear_points_m: npt.ArrayLike | None = None,
        sent: Twist2D | None = None,
    ) -> MissionStep:
        """One step, at 20 Hz. pose: by odometry, at stamp_ns. detections, answers: what arrived since the last step.

        rear_points_m [k, 2], sent: for the navigator, as in `Navigator.step`.
        Raises RefusedError for a stamp that is not after the last one.
        """
        self._sightings.add_pose(stamp_ns, pose)
        self._stamp_ns, self._for_navigator = stamp_ns, (rear_points_m, sent)
        self._sightings.add(detections, inspecting=self.state in (MissionState.DRIVING, MissionState.INSPECTING))
        self._take(stamp_ns, answers)
        if self._inspection is not None and self._inspection.is_over(stamp_ns):
            self._end_inspection(self._inspection)
        if self.state is MissionState.DRIVING:
            self._begin_inspection(stamp_ns, pose)
        if self._inspection is not None:
            return self._inspect(stamp_ns, scan, pose, self._inspection)
        if self.state is MissionState.DRIVING:
            return self._drive(stamp_ns, scan, pose)
        return self._stand(stamp_ns, scan, pose)

    def _drive(self, stamp_ns: int, scan: Scan | None, pose: Pose2D) -> MissionStep:
        """Towards the next goal."""
        goal, self._halt = self._goals[0], None
        # In another list the same id is another goal, which the navigator cannot know.
        twist, progress = self._navigate(stamp_ns, scan, pose, replace(goal, id=f"{goal.id}/{self._lists}"))
        if progress.state is State.BLOCKED:
            self._become(MissionState.BLOCKED, progress.reason.value if progress.reason else "blocked")
        elif progress.state is State.ARRIVED:
            self._arrive(stamp_ns)
        return self._answer(twist, goal, replace(progress, goal_id=goal.id), note=progress.note)

    def _navigate(self, stamp_ns: int, scan: Scan | None, pose: Pose2D, goal: Goal) -> tuple[Twist2D, Progress]:
        return self._navigator.step(stamp_ns, scan, pose, goal, *self._for_navigator)

    def _arrive(self, stamp_ns: int) -> None:
        """On to the next goal, or after a last look around it has arrived."""
        if len(self._goals) > 1:
            self._goals.pop(0)
            return
        if self._there_ns is None:
            self._there_ns = stamp_ns
        look_s = self._settings.last_look_s if self._settings.interest else 0.0
        if stamp_ns - self._there_ns >= round(look_s * 1e9):
            self._become(MissionState.ARRIVED)

    def _stand(
        self, stamp_ns: int, scan: Scan | None, pose: Pose2D, request: PictureRequest | None = None, note: str = ""
    ) -> MissionStep:
        """Still; the navigator is told all the same, so that it goes on seeing what the laser sees."""
        self._halt = self._halt or Goal("mission/stand", pose, BRAKING_WAY_M, math.pi)
        self._navigate(stamp_ns, scan, pose, self._halt)
        return self._answer(Twist2D(), self._goals[0] if self._goals else None, request=request, note=note)

    def _begin_inspection(self, stamp_ns: int, pose: Pose2D) -> None:
        """Of the nearest object that is due."""
        target = self._sightings.objects.next_due((pose.x_m, pose.y_m))
        if target is None:
            return
        target.visited = True
        self._inspections += 1
        self._inspection = Inspection(f"inspection-{self._inspections}", target, self._settings, stamp_ns)
        self._there_ns = None
        self._become(MissionState.INSPECTING)

    def _inspect(self, stamp_ns: int, scan: Scan | None, pose: Pose2D, inspection: Inspection) -> MissionStep:
        """Stand or turn, as its phase wants."""
        request = inspection.step(stamp_ns, pose, self._sightings.is_at_rest(stamp_ns, pose))
        note = f"{inspection.phase.value}: {inspection.label}"
        if inspection.goal is None:
            return self._stand(stamp_ns, scan, pose, request, note)
        self._halt = None
        twist, progress = self._navigate(stamp_ns, scan, pose, inspection.goal)
        inspection.turned(stamp_ns, progress)
        return self._answer(twist, self._goals[0], progress, note=note)

    def _take(self, stamp_ns: int, answers: Sequence[PictureAnswer]) -> None:
        """To whom an answer is for."""
        for answer in answers:
            if self._inspection is None or not self._inspection.take(stamp_ns, answer):
                self.refused_answers += 1

    def _end_inspection(self, inspection: Inspection, interrupted: str = "") -> None:
        """And go on driving."""
        if interrupted and not inspection.pictured:
            self._sightings.objects.not_visited(inspection.kind, inspection.place_m)
        self._result, self._inspection = inspection.result(self._stamp_ns, interrupted), None
        self._become(MissionState.DRIVING)

    def _become(self, state: MissionState, reason: str = "") -> None:
        self.state, self.reason = state, reason
        if state in (MissionState.ARRIVED, MissionState.BLOCKED):
            self._goals.clear()

    def _answer(
        self,
        twist: Twist2D,
        goal: Goal | None,
        progress: Progress | None = None,
        request: PictureRequest | None = None,
        note: str = "",
    ) -> MissionStep:
        result, self._result = self._result, None
        return MissionStep(twist, self.state, self.reason, goal, progress, request, result, note)
