# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""An inspection from the object that is seen to the picture that is kept: base's part, vision's, and what goes between
them, in simulated time, also where messages are lost."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import pytest

from base_scenes import MS, Bench
from bus_base import detection
from camera_scenes import scene
from edgefusion.bus.topics import INSPECTION, INSPECTION_META, INSPECTION_REQUEST, Topic
from edgefusion.config import Config, MissionConfig
from edgefusion.messages.cdr import WireError
from edgefusion.messages.mission_report import InspectionReport
from edgefusion.messages.picture_exchange import PictureAnswerDetail, from_picture_exchange, to_picture_request
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.std_msgs import String
from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.perception.detector import StageTimes
from edgefusion.service.base_inspections import AGAIN_HZ, InspectionOutlet
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.picture_exchange import picture_answer
from edgefusion.service.vision_inspections import VisionInspections
from edgefusion.service.vision_look import Look
from edgefusion.tools.inspection_files import save_inspection
from edgefusion.types import Detection, Frame, Goal, Pose2D
from vision_scenes import scan

PLACE = Pose2D(2.0, 0.8)
MISSION = MissionConfig(interest=("oscilloscope",), stand_s=0.5)
JPEG = b"\xff\xd8\xff a picture"


class Line:
    """Of a topic, to somebody who always listens. said: when, and what."""

    def __init__(self, max_hz: float) -> None:
        self._period_ns, self._due_ns = round(1e9 / max_hz), 0
        self.said: list[tuple[int, Any]] = []

    def wanted(self, now_ns: int) -> bool:
        if now_ns < self._due_ns:
            return False
        self._due_ns = now_ns + self._period_ns
        return True

    def put(self, message: Any, stamp_ns: int) -> None:
        self.said.append((stamp_ns, message))


@dataclass
class Together:
    """lost_requests, lost_answers: so many of the first. blind: why vision sees nothing from when it is asked."""

    lost_requests: int = 0
    lost_answers: int = 0
    blind: str = ""
    lines: dict[Topic, Line] = field(default_factory=dict)
    results: list[InspectionResult] = field(default_factory=list)
    _pictures: list = field(default_factory=list)
    _seen: tuple[Detection, ...] = ()

    def __post_init__(self) -> None:
        self.loop, self.bench = BaseLoop(Config(mission=MISSION)), Bench()
        self.bench.loop = self  # between the bench and the loop: what comes from vision
        self.vision = VisionInspections(MISSION.same_place_m, lambda look, shown: JPEG)
        self.outlet = InspectionOutlet(self._line, Stamper())

    def _line(self, topic: Topic, max_hz: float) -> Line:
        return self.lines.setdefault(topic, Line(max_hz))

    def step(self, now_ns: int, inputs: Any) -> Any:
        pictures, self._pictures = self._pictures, []
        seen_ns = now_ns if self._seen else None
        return self.loop.step(
            now_ns, replace(inputs, detections=self._seen, detections_ns=seen_ns, pictures=tuple(pictures))
        )

    def tick(self) -> None:
        outputs = self.bench.tick()
        asked = len(self.lines[INSPECTION_REQUEST].said)
        self.outlet.tell(outputs)
        for _, message in self.lines[INSPECTION_REQUEST].said[asked:]:
            self._ask(message)
        if outputs.mission.result is not None:
            self.results.append(outputs.mission.result)
        self._look(outputs.stamp_ns)

    def run(self) -> Together:
        """To the goal, past the object."""
        for _ in range(20):
            self.tick()
        self.loop.goto([Goal("beyond", Pose2D(1.2, 0.0))])
        for _ in range(400):
            self.tick()
        return self

    def _ask(self, message: String) -> None:
        if self.lost_requests:
            self.lost_requests -= 1
            return
        self.vision.ask(to_picture_request(message))

    def _look(self, now_ns: int) -> None:
        pose = self.bench.simulation.pose
        at = PLACE.relative_to(pose)
        seen = replace(detection(now_ns), position_m=(at.x_m, at.y_m))
        self._seen = (seen,)
        look = Look(scan(now_ns), Frame(now_ns, scene(1)), pose, (seen,), StageTimes(0, 0, 0, 0), now_ns, now_ns)
        if self.blind and self.lines[INSPECTION_REQUEST].said:
            self._seen = ()
            answer = self.vision.expire(now_ns, self.blind)
        else:
            answer = self.vision.look(look)
        if answer is not None:
            self._answer(answer)

    def _answer(self, answer: PictureAnswerDetail) -> None:
        if self.lost_answers:
            self.lost_answers -= 1
            return
        self._pictures.append(picture_answer(from_picture_exchange(answer)))

    def metas(self) -> list[InspectionReport]:
        return [
            msgspec.json.decode(message.data, type=InspectionReport) for _, message in self.lines[INSPECTION_META].said
        ]


def kept(folder: Path, result: InspectionResult) -> dict:
    return json.loads(save_inspection(folder, result).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def lossy() -> Together:
    """The first requests are lost."""
    return Together(lost_requests=3).run()


def test_what_vision_pictures_goes_to_everyone_and_is_kept_byte_by_byte(lossy: Together, tmp_path: Path) -> None:
    it, (result,) = lossy, lossy.results
    ((stamp_ns, picture),) = it.lines[INSPECTION].said
    (meta,) = it.metas()
    record = kept(tmp_path, result)
    assert bytes(picture.data) == JPEG == (tmp_path / record["picture"]["file"]).read_bytes()
    assert record["picture"]["stamp_ns"] == meta.picture_ns == stamp_ns
    assert (meta.label, meta.reason) == (record["label"], record["reason"]) == ("oscilloscope", "")
    assert meta.place_m == pytest.approx((PLACE.x_m, PLACE.y_m), abs=0.1)


def test_a_request_is_said_again_until_the_inspection_has_ended_and_never_after(lossy: Together) -> None:
    times_ns = [ns for ns, _ in lossy.lines[INSPECTION_REQUEST].said]
    (result,) = lossy.results
    assert len(times_ns) >= 4
    assert min(later - earlier for earlier, later in zip(times_ns, times_ns[1:])) >= round(1e9 / AGAIN_HZ)
    assert times_ns[-1] <= result.ended_ns


@pytest.mark.parametrize(
    ("so", "reason"),
    [({"lost_answers": 1000}, ""), ({"blind": "CAMERA_LOST: unplugged"}, "CAMERA_LOST: unplugged")],
    ids=["no answer arrives", "vision sees nothing"],
)
def test_without_a_picture_the_robot_goes_on_and_everybody_is_told_why(so: dict, reason: str, tmp_path: Path) -> None:
    it = Together(**so).run()
    (result,) = it.results
    (meta,) = it.metas()
    assert reason in result.reason
    assert meta.reason == kept(tmp_path, result)["reason"] == result.reason != ""
    assert meta.picture_ns is None
    assert kept(tmp_path, result)["picture"] is None
    assert it.lines[INSPECTION].said == []
    waited_ns = result.ended_ns - result.stood_ns
    assert waited_ns <= (MISSION.picture_s + MISSION.stand_s) * 1e9 + 100 * MS


@pytest.mark.parametrize(
    "change",
    [{"reason": "and yet a picture"}, {"jpeg": None}, {"version": 2}, {"stamp_ns": "soon"}, {"more": 1}],
    ids=lambda change: next(iter(change)),
)
def test_an_answer_that_is_none_is_refused(change: dict) -> None:
    answer = msgspec.to_builtins(PictureAnswerDetail(request_id="i", stamp_ns=5, jpeg=JPEG))
    assert picture_answer(String(json.dumps(answer))).image == JPEG
    with pytest.raises(WireError):
        picture_answer(String(json.dumps({**answer, **change})))
