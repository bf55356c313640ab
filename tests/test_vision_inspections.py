# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures for the mission: of the thing that it stands before, once, or the reason why there is none."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import pytest

from bus_base import detection
from camera_scenes import scene
from edgefusion.messages.picture_exchange import PictureRequestDetail
from edgefusion.perception.detector import StageTimes
from edgefusion.service.vision_inspections import VisionInspections
from edgefusion.service.vision_look import Look
from edgefusion.types import Detection, Frame, Pose2D
from vision_scenes import MS, scan

ASKED_NS = 5_000 * MS
POSE = Pose2D(1.0, 0.0)
REQUEST = PictureRequestDetail(
    id="inspection-1", label="oscilloscope", group="instrument", place_m=(3.0, 0.2), stamp_ns=ASKED_NS,
    deadline_ns=ASKED_NS + 3000 * MS,
)  # fmt: skip


def drawn(look: Look, detections: Sequence[Detection]) -> bytes:
    return f"{look.frame.stamp_ns}:{len(detections)}".encode()


def look(after_ms: int, pose: Pose2D | None = POSE, **changes: object) -> Look:
    """What is seen is at (3.0, 0.2) in `odom` where nothing is changed."""
    stamp_ns = ASKED_NS + after_ms * MS
    seen = replace(detection(stamp_ns), **changes)
    times = StageTimes(0, 0, 0, 0)
    return Look(scan(stamp_ns), Frame(stamp_ns, scene(1)), pose, (seen,), times, stamp_ns, stamp_ns + 100 * MS)


@pytest.fixture
def desk() -> VisionInspections:
    desk = VisionInspections(0.6, drawn)
    desk.ask(REQUEST)
    return desk


def test_the_answer_is_the_first_frame_from_the_request_on_with_the_box_of_what_was_asked_for(desk) -> None:
    assert desk.look(look(-1)) is None
    answer = desk.look(look(10))
    assert (answer.request_id, answer.stamp_ns) == ("inspection-1", ASKED_NS + 10 * MS)
    assert answer.jpeg == f"{answer.stamp_ns}:1".encode()
    assert answer.detection is not None
    assert answer.detection.label == "oscilloscope"


def test_a_request_that_is_repeated_is_answered_once(desk) -> None:
    assert desk.look(look(10)) is not None
    desk.ask(REQUEST)
    assert desk.look(look(20)) is None


def test_another_label_of_the_same_group_is_what_was_asked_for(desk) -> None:
    assert desk.look(look(10, label="multimeter")).detection is not None


@pytest.mark.parametrize(
    "seen",
    [look(0, label="bookcase", group=""), look(0, position_m=(2.0, 0.9)), look(0, pose=None)],
    ids=["another thing", "elsewhere", "nobody knows where"],
)
def test_where_it_is_not_seen_the_third_frame_is_the_answer_without_a_box(desk, seen: Look) -> None:
    assert [desk.look(seen) for _ in range(2)] == [None, None]
    answer = desk.look(seen)
    assert answer.jpeg == f"{ASKED_NS}:0".encode()
    assert answer.detection is None


def test_without_a_frame_in_time_the_answer_is_the_reason(desk) -> None:
    assert desk.expire(ASKED_NS + 2000 * MS, "CAMERA_LOST: unplugged") is None
    answer = desk.expire(ASKED_NS + 2600 * MS, "CAMERA_LOST: unplugged")
    assert (answer.request_id, answer.jpeg, answer.reason) == ("inspection-1", None, "CAMERA_LOST: unplugged")
    assert desk.expire(ASKED_NS + 2700 * MS, "") is None


def test_a_new_request_replaces_the_one_that_waits(desk) -> None:
    desk.ask(PictureRequestDetail(**{**{f: getattr(REQUEST, f) for f in REQUEST.__struct_fields__}, "id": "other"}))
    assert desk.look(look(10)).request_id == "other"
