# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated base on open ground, a detector of known answers that is late, and a mission that drives it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Callable, NamedTuple, Sequence

import numpy as np

from edgefusion.navigation.inspection_result import InspectionResult, PictureAnswer, PictureRequest
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.navigation.progress import Progress, Reason, State
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.types import ClassScore, Cluster, Detection, Goal, Pose2D, Twist2D, Vote
from straight_drive import StraightDrive

S = 1_000_000_000
TICK_NS, FRAME_NS, LATE_NS, PICTURE_NS = 50_000_000, 200_000_000, 400_000_000, 800_000_000
"""A command 20 times, a frame 5 times a second; detections are 0.4 s late; a picture takes 0.8 s."""

HALF_VIEW = math.radians(30)
SCORE = ClassScore(0, "oscilloscope", 0.9)
DETECTION = Detection(
    stamp_ns=0, class_index=0, label="oscilloscope", group="", score=0.9, margin=0.8, box=(1, 2, 3, 4),
    distance_m=2.0, distance_sigma_m=0.01, bearing=0.0, position_m=(2.0, 0.0), vote=Vote((SCORE,), 0, 0.8, ((SCORE,),)),
    boxes=((1, 2, 3, 4),), cluster=Cluster(np.arange(3), 2.0, 0.0, 0.3), scan_frame_dt_ns=0,
)  # fmt: skip


class Thing(NamedTuple):
    """What stands in the world, of which `odom` is the frame here: the wheels do not slip."""

    x_m: float
    y_m: float
    label: str = "oscilloscope"
    group: str = ""
    score: float = 0.9


def seen(thing: Thing, pose: Pose2D, stamp_ns: int) -> Detection:
    """The detection of a thing from a pose, whether it is in view or not."""
    there = Pose2D(thing.x_m, thing.y_m).relative_to(pose)
    distance_m, bearing = math.hypot(there.x_m, there.y_m), math.atan2(there.y_m, there.x_m)
    return replace(
        DETECTION, stamp_ns=stamp_ns, label=thing.label, group=thing.group, score=thing.score,
        distance_m=distance_m, bearing=bearing, position_m=(there.x_m, there.y_m),
    )  # fmt: skip


class OpenGround:
    """A navigator that sees nothing: it drives straight to the goal. jams: goals that end BLOCKED; stiff: those to
    which it does not move."""

    def __init__(self, jams: Callable[[Goal], bool] | None = None, stiff: Callable[[Goal], bool] | None = None) -> None:
        self._jams, self._stiff = jams or (lambda goal: False), stiff or (lambda goal: False)
        self._id, self._follower = "", StraightDrive(Goal("", Pose2D()))
        self.stamps_ns: list[int] = []

    def step(self, stamp_ns, scan, pose, goal, rear_points_m=None, sent=None) -> tuple[Twist2D, Progress]:
        self.stamps_ns.append(stamp_ns)
        if goal.id != self._id:
            self._id, self._follower = goal.id, StraightDrive(goal)
        way_m = self._follower.way_left_m(pose)
        if self._jams(goal):
            return Twist2D(), Progress(goal.id, State.BLOCKED, way_m, reason=Reason.ENCLOSED)
        if self._stiff(goal):
            return Twist2D(), Progress(goal.id, State.DRIVING, way_m)
        twist = self._follower.step(pose)
        return twist, Progress(goal.id, State.ARRIVED if self._follower.arrived else State.DRIVING, way_m)


class Row(NamedTuple):
    """A step, and where the base was and how fast when it was taken."""

    stamp_ns: int
    pose: Pose2D
    twist: Twist2D
    step: MissionStep


@dataclass
class Scene:
    """Drives a mission; `rows` fills up. answering: whether vision gives pictures; extra: answers for the next step."""

    mission: Mission
    things: Sequence[Thing] = ()
    answering: bool = True
    base: SimBase = field(default_factory=lambda: SimBase(BaseSpec(max_speed_mps=0.5)))
    rows: list[Row] = field(default_factory=list)
    extra: list[PictureAnswer] = field(default_factory=list)
    _on_their_way: list[tuple[int, Detection]] = field(default_factory=list)
    _asked: list[PictureRequest] = field(default_factory=list)

    def run(self, seconds: float, until: Callable[[MissionStep], bool] = lambda step: False) -> list[Row]:
        """For so long, or until a step is such; the rows of this run."""
        begin = len(self.rows)
        for _ in range(round(seconds * S / TICK_NS)):
            self._tick()
            if until(self.rows[-1].step):
                break
        return self.rows[begin:]

    def _tick(self) -> None:
        base, now_ns = self.base, self.base.stamp_ns
        if now_ns % FRAME_NS == 0:
            self._on_their_way += [(now_ns + LATE_NS, detection) for detection in self._view()]
        arrived = [detection for due_ns, detection in self._on_their_way if due_ns <= now_ns]
        self._on_their_way = [each for each in self._on_their_way if each[0] > now_ns]
        step = self.mission.step(now_ns, None, base.odometry, arrived, self._answers())
        if step.request is not None:
            self._asked.append(step.request)
        self.rows.append(Row(now_ns, base.odometry, base.twist, step))
        base.command(step.twist)
        base.step(TICK_NS)

    def _view(self) -> list[Detection]:
        detections = [seen(thing, self.base.odometry, self.base.stamp_ns) for thing in self.things]
        return [each for each in detections if abs(each.bearing) < HALF_VIEW]

    def _answers(self) -> list[PictureAnswer]:
        now_ns = self.base.stamp_ns
        due = [each for each in self._asked if self.answering and now_ns >= each.stamp_ns + PICTURE_NS]
        self._asked = [each for each in self._asked if each not in due]
        extra, self.extra = self.extra, []
        return [*extra, *(PictureAnswer(each.id, now_ns - PICTURE_NS // 2, b"a picture") for each in due)]


def arrived(step: MissionStep) -> bool:
    return step.state is MissionState.ARRIVED


def inspecting(step: MissionStep) -> bool:
    return step.state is MissionState.INSPECTING


def asks(step: MissionStep) -> bool:
    return step.request is not None


def results(rows: Sequence[Row]) -> list[InspectionResult]:
    return [row.step.result for row in rows if row.step.result is not None]


def states(rows: Sequence[Row]) -> list[str]:
    """The states gone through, each once in a row."""
    names = [row.step.state.value for row in rows]
    return [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
