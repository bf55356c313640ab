# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One stop at an object: brake, face it, stand, have a picture taken."""

from __future__ import annotations

import math
from enum import Enum

from edgefusion.config import MissionConfig
from edgefusion.navigation.inspection_result import InspectionResult, PictureAnswer, PictureRequest
from edgefusion.navigation.objects import KnownObject, Point
from edgefusion.navigation.progress import Progress, State
from edgefusion.types import Goal, Pose2D

REST_NS = 10_000_000_000
"""A robot that was stopped and is not at rest after so long is taken as it is: others judge a broken brake."""

FACING_PLACE_M = 0.25
"""How far turning may carry the robot from where it stopped."""


class Phase(str, Enum):
    """SETTLING: it has turned, and comes to rest."""

    BRAKING = "braking"
    FACING = "facing"
    SETTLING = "settling"
    STANDING = "standing"


class Inspection:
    """Goes through the phases, told the time, the pose and whether the robot is at rest.

    goal: the pose to turn to while `phase` is FACING, None in the others, in which the robot is to stand.
    """

    def __init__(self, id: str, target: KnownObject, settings: MissionConfig, stamp_ns: int) -> None:
        self.id, self._target, self._settings = id, target, settings
        self.phase, self._phase_by_ns = Phase.BRAKING, stamp_ns + REST_NS
        self.goal: Goal | None = None
        self._begun_ns = stamp_ns
        self._request: PictureRequest | None = None
        self._answer: PictureAnswer | None = None
        self._pose = Pose2D()
        self._notes: list[str] = []

    @property
    def kind(self) -> str:
        return self._target.kind

    @property
    def label(self) -> str:
        return self._target.best.label

    @property
    def place_m(self) -> Point:
        return self._target.place_m

    @property
    def pictured(self) -> bool:
        return self._answer is not None and self._answer.image is not None

    def step(self, stamp_ns: int, pose: Pose2D, at_rest: bool) -> PictureRequest | None:
        """Goes on to the next phase when it is time; the request for a picture, once."""
        if self.phase is not Phase.STANDING:
            self._pose = pose
        timed_out = stamp_ns >= self._phase_by_ns
        if self.phase is Phase.FACING and timed_out:
            self._settle(stamp_ns, f"does not face it: given up after {self._settings.facing_s:g} s")
        elif self.phase in (Phase.BRAKING, Phase.SETTLING) and (at_rest or timed_out):
            if not at_rest:
                self._notes.append(f"does not come to rest while {self.phase.value}")
            return self._face(stamp_ns) if self.phase is Phase.BRAKING else self._stand(stamp_ns)
        return None

    def turned(self, stamp_ns: int, progress: Progress) -> None:
        """How far the navigator has got with `goal`."""
        if progress.state is State.ARRIVED:
            self._settle(stamp_ns)
        elif progress.state is State.BLOCKED:
            why = progress.reason.value if progress.reason else "blocked"
            self._settle(stamp_ns, f"does not face it: {why}")

    def take(self, stamp_ns: int, answer: PictureAnswer) -> bool:
        """An answer that arrived at a time; False if it is not the one that is waited for, or no longer."""
        request = self._request
        if request is None or self._answer is not None or answer.request_id != request.id:
            return False
        if stamp_ns > request.deadline_ns or not request.stamp_ns <= answer.stamp_ns <= stamp_ns:
            return False
        self._answer = answer
        return True

    def is_over(self, stamp_ns: int) -> bool:
        """It stood long enough, and a picture will no longer come."""
        if self._request is None or stamp_ns < self._request.stamp_ns + round(self._settings.stand_s * 1e9):
            return False
        return self._answer is not None or stamp_ns > self._request.deadline_ns

    def result(self, stamp_ns: int, interrupted: str = "") -> InspectionResult:
        """What came of it. interrupted: by what it is ended early."""
        answer, best = self._answer, self._target.best
        picture = answer if answer is not None and answer.image is not None else None
        return InspectionResult(
            id=self.id,
            label=best.label,
            group=best.group,
            place_m=self.place_m,
            pose=self._pose,
            detection=best if picture is None or picture.detection is None else picture.detection,
            begun_ns=self._begun_ns,
            stood_ns=None if self._request is None else self._request.stamp_ns,
            ended_ns=stamp_ns,
            picture=picture,
            reason="" if picture is not None else self._why_none(interrupted),
            note="; ".join([*self._notes, interrupted] if interrupted else self._notes),
        )

    def _face(self, stamp_ns: int) -> PictureRequest | None:
        (x_m, y_m), here, settings = self.place_m, self._pose, self._settings
        facing = Pose2D(here.x_m, here.y_m, math.atan2(y_m - here.y_m, x_m - here.x_m))
        self.goal = Goal(f"{self.id}/facing", facing, FACING_PLACE_M, settings.facing_tolerance)
        self.phase, self._phase_by_ns = Phase.FACING, stamp_ns + round(settings.facing_s * 1e9)
        return None

    def _settle(self, stamp_ns: int, note: str = "") -> None:
        self.goal, self.phase, self._phase_by_ns = None, Phase.SETTLING, stamp_ns + REST_NS
        if note:
            self._notes.append(note)

    def _stand(self, stamp_ns: int) -> PictureRequest:
        best, deadline_ns = self._target.best, stamp_ns + round(self._settings.picture_s * 1e9)
        self.phase = Phase.STANDING
        self._request = PictureRequest(self.id, best.label, best.group, self.place_m, stamp_ns, deadline_ns)
        return self._request

    def _why_none(self, interrupted: str) -> str:
        if self._answer is not None:
            return f"vision: {self._answer.reason}"
        return interrupted or f"no answer within {self._settings.picture_s:g} s"
