# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""On the way to its goal the robot stops at what is of interest, faces it, stands and has its picture taken: once."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from edgefusion.config import MissionConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.inspection_result import PictureAnswer
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState
from edgefusion.navigation.progress import State
from edgefusion.types import Goal, Pose2D, Twist2D
from mission_scenes import (
    DETECTION,
    LATE_NS,
    PICTURE_NS,
    TICK_NS,
    OpenGround,
    Row,
    S,
    Scene,
    Thing,
    arrived,
    asks,
    inspecting,
    results,
    seen,
    states,
)  # fmt: skip

SETTINGS = MissionConfig()
FAR = Goal("far", Pose2D(5, 0, 1.0))
SCOPE = Thing(3.0, 0.8)


def drive_by(
    *things: Thing, settings: MissionConfig = SETTINGS, navigator: OpenGround | None = None, answering: bool = True
) -> Scene:
    scene = Scene(Mission(settings, navigator or OpenGround()), things, answering)
    scene.mission.goto([FAR])
    return scene


def off_rad(pose: Pose2D, thing: Thing) -> float:
    """How far a robot is from facing a thing."""
    there = Pose2D(thing.x_m, thing.y_m).relative_to(pose)
    return abs(math.atan2(there.y_m, there.x_m))


def standing(rows: list[Row]) -> list[Row]:
    return [row for row in rows if row.step.note.startswith("standing")]


def test_it_drives_stops_at_the_object_and_drives_on_to_its_goal() -> None:
    scene = drive_by(SCOPE)
    rows = scene.run(60, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    off = scene.base.pose.relative_to(FAR.pose)
    assert math.hypot(off.x_m, off.y_m) < 2 * FAR.position_tolerance_m and abs(off.theta) < 2 * FAR.heading_tolerance


def test_it_stops_when_the_third_frame_has_come_and_brakes_as_fast_as_the_base_can() -> None:
    rows = drive_by(SCOPE).run(60, inspecting)
    assert rows[-1].stamp_ns == 2 * 200_000_000 + LATE_NS
    scene = drive_by(SCOPE)
    rows = [row for row in scene.run(60, arrived) if row.step.note.startswith("braking")]
    assert rows[0].twist.v_mps > 0.2
    assert {row.step.twist for row in rows} == {Twist2D()}
    at_rest_ns = next(row.stamp_ns for row in rows if row.twist == Twist2D())
    # It notices its rest within the 0.2 s that it looks back.
    assert rows[-1].stamp_ns - at_rest_ns <= 200_000_000 + TICK_NS


@pytest.mark.parametrize("thing", [SCOPE, Thing(2.0, -1.0), Thing(3.5, 0.0)], ids=["left", "right", "ahead"])
def test_it_faces_the_object_within_the_tolerance_and_stands_still_for_ten_seconds(thing: Thing) -> None:
    rows = drive_by(thing).run(60, arrived)
    (result,) = results(rows)
    assert result.stood_ns is not None
    assert result.ended_ns - result.stood_ns == 10 * S
    stood = [row for row in rows if result.stood_ns <= row.stamp_ns < result.ended_ns]
    assert len({row.pose for row in stood}) == 1
    assert {row.twist for row in stood} == {Twist2D()}
    assert off_rad(result.pose, thing) <= SETTINGS.facing_tolerance
    assert result.pose == stood[0].pose


def test_the_picture_is_asked_for_once_from_standing() -> None:
    rows = drive_by(SCOPE).run(60, arrived)
    (asking,) = (row for row in rows if row.step.request)
    request = asking.step.request
    assert request is not None
    assert asking.twist == Twist2D()
    assert (request.label, request.stamp_ns, request.deadline_ns) == (
        "oscilloscope", asking.stamp_ns, asking.stamp_ns + 3 * S,
    )  # fmt: skip
    assert request.place_m == pytest.approx((SCOPE.x_m, SCOPE.y_m), abs=0.01)
    (result,) = results(rows)
    assert result.id == request.id
    assert result.picture is not None
    assert (result.picture.image, result.reason, result.note) == (b"a picture", "", "")


def test_the_object_is_placed_by_where_the_robot_was_when_it_was_seen() -> None:
    """It is seen from up to 0.24 m/s, 0.4 s before the mission hears of it: 0.1 m and more off, taken as of now."""
    (result,) = results(drive_by(SCOPE).run(60, arrived))
    assert result.place_m == pytest.approx((SCOPE.x_m, SCOPE.y_m), abs=0.01)


def test_the_detection_is_the_pictures_else_the_best_of_those_that_found_the_object() -> None:
    (result,) = results(drive_by(SCOPE).run(60, arrived))
    assert result.detection.score == SCOPE.score
    scene = drive_by(SCOPE, answering=False)
    asked = scene.run(60, asks)[-1].step.request
    assert asked is not None
    now = replace(DETECTION, score=0.7)
    scene.extra = [PictureAnswer(asked.id, asked.stamp_ns + TICK_NS, b"a picture", now)]
    (result,) = results(scene.run(60, arrived))
    assert result.detection is now


def test_without_an_answer_the_result_says_so_and_the_mission_goes_on() -> None:
    rows = drive_by(SCOPE, answering=False).run(60, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    (result,) = results(rows)
    assert (result.picture, result.reason) == (None, "no answer within 3 s")
    assert result.stood_ns is not None and result.ended_ns - result.stood_ns == 10 * S


def test_vision_may_answer_why_there_is_no_picture() -> None:
    scene = drive_by(SCOPE, answering=False)
    asked = scene.run(60, asks)[-1].step.request
    assert asked is not None
    scene.extra = [PictureAnswer(asked.id, asked.stamp_ns, None, reason="camera lost")]
    (result,) = results(scene.run(60, arrived))
    assert (result.picture, result.reason) == (None, "vision: camera lost")


@pytest.mark.parametrize(("waited_s", "taken"), [(2.95, True), (3.0, False)], ids=["in time", "late"])
def test_an_answer_counts_until_its_deadline(waited_s: float, taken: bool) -> None:
    scene = drive_by(SCOPE, answering=False)
    asked = scene.run(60, asks)[-1].step.request
    assert asked is not None
    scene.run(waited_s)
    scene.extra = [PictureAnswer(asked.id, asked.stamp_ns, b"a picture")]
    (result,) = results(scene.run(60, arrived))
    assert (result.picture is not None) == taken
    assert scene.mission.refused_answers == (0 if taken else 1)


def test_answers_of_another_id_or_time_or_that_nobody_asked_for_are_refused_and_counted() -> None:
    scene = drive_by(SCOPE, answering=False)
    scene.extra = [PictureAnswer("inspection-1", 0, b"before there was a request")]
    asked = scene.run(60, asks)[-1].step.request
    assert asked is not None
    scene.extra = [
        PictureAnswer("inspection-2", asked.stamp_ns, b"another id"),
        PictureAnswer(asked.id, asked.stamp_ns - 1, b"taken before it stood"),
        PictureAnswer(asked.id, asked.stamp_ns + S, b"taken in the future"),
        PictureAnswer(asked.id, asked.stamp_ns, b"the picture"),
        PictureAnswer(asked.id, asked.stamp_ns, b"a second one"),
    ]
    (result,) = results(scene.run(60, arrived))
    assert result.picture is not None and result.picture.image == b"the picture"
    assert scene.mission.refused_answers == 5


@pytest.mark.parametrize(("image", "reason"), [(None, ""), (b"x", "none")], ids=["neither", "both"])
def test_an_answer_is_a_picture_or_a_reason(image: object, reason: str) -> None:
    with pytest.raises(RefusedError, match=r"picture 'a': expected an image or the reason why not, got (neither|both)"):
        PictureAnswer("a", 0, image, reason=reason)


def test_a_picture_that_takes_longer_than_the_stop_is_waited_for() -> None:
    settings = MissionConfig(stand_s=0.2)
    (result,) = results(drive_by(SCOPE, settings=settings).run(60, arrived))
    assert result.picture is not None and result.stood_ns is not None
    assert result.ended_ns - result.stood_ns == PICTURE_NS


def test_where_it_cannot_turn_it_gives_up_in_time_says_so_and_stands_all_the_same() -> None:
    stiff = OpenGround(stiff=lambda goal: "facing" in goal.id)
    rows = drive_by(SCOPE, navigator=stiff).run(90, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    (result,) = results(rows)
    assert result.note == "does not face it: given up after 15 s"
    assert result.picture is not None
    facing = [row.stamp_ns for row in rows if row.step.note.startswith("facing")]
    assert facing[-1] - facing[0] == 15 * S - TICK_NS


def test_where_the_navigator_is_blocked_in_turning_it_says_why() -> None:
    (result,) = results(drive_by(SCOPE, navigator=OpenGround(jams=lambda goal: "facing" in goal.id)).run(60, arrived))
    assert result.note == "does not face it: goal enclosed"
    assert result.picture is not None


def test_a_robot_that_does_not_come_to_rest_is_inspected_from_after_a_while_and_that_is_said() -> None:
    """Its brakes are the safety gate's matter; the mission does not wait for ever."""
    mission = Mission(MissionConfig(stand_s=1.0), OpenGround(jams=lambda goal: "facing" in goal.id))
    mission.goto([FAR])
    result = None
    for tick in range(600):
        stamp_ns, pose = tick * TICK_NS, Pose2D(-0.005 * tick, 0)
        result = mission.step(stamp_ns, None, pose, [seen(SCOPE, pose, stamp_ns)]).result or result
    assert result is not None
    assert result.stood_ns is not None
    assert result.pose.x_m == pytest.approx(-0.005 * result.stood_ns / TICK_NS)
    assert result.note == (
        "does not come to rest while braking; does not face it: goal enclosed; does not come to rest while settling"
    )


@pytest.mark.parametrize(
    "thing",
    [SCOPE._replace(label="joystick"), SCOPE._replace(score=0.29), Thing(5.0, 4.5)],
    ids=["another label", "an unsure one", "too far"],
)
def test_what_is_not_of_interest_is_driven_by(thing: Thing) -> None:
    assert states(drive_by(thing).run(60, arrived)) == ["driving", "arrived"]


def test_interest_may_name_a_group_and_its_labels_at_one_place_are_one_object() -> None:
    """From the side a minivan, from behind a beach wagon."""
    sides = [Thing(3.0, 0.8, "minivan", "car"), Thing(3.1, 0.9, "beach wagon", "car")]
    rows = drive_by(*sides, settings=MissionConfig(interest=("car",))).run(90, arrived)
    assert len(results(rows)) == 1


def test_two_oscilloscopes_apart_are_two_objects_and_each_is_inspected() -> None:
    things = [Thing(2.5, 0.7), Thing(2.5, -0.7)]
    rows = drive_by(*things).run(90, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    places = sorted(result.place_m for result in results(rows))
    assert places == [pytest.approx((x, y), abs=0.01) for x, y, *_ in sorted(things)]
    assert len({result.id for result in results(rows)}) == 2


def test_what_comes_into_view_in_turning_to_another_object_is_inspected_next_without_driving_on() -> None:
    rows = drive_by(Thing(3.0, 1.4), Thing(2.7, 2.6)).run(90, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    assert [result.place_m for result in results(rows)] == [
        pytest.approx((3.0, 1.4), abs=0.01), pytest.approx((2.7, 2.6), abs=0.01),
    ]  # fmt: skip


def test_an_object_is_not_visited_again_on_the_way_back() -> None:
    scene = drive_by(SCOPE)
    scene.run(60, arrived)
    scene.mission.goto([Goal("home", Pose2D()), Goal("again", FAR.pose)])
    rows = scene.run(120, arrived)
    assert states(rows) == ["driving", "arrived"]
    assert math.hypot(scene.base.pose.x_m - 5, scene.base.pose.y_m) < 0.1


def test_what_was_seen_while_idle_is_inspected_when_it_is_seen_on_the_way() -> None:
    scene = Scene(Mission(SETTINGS, OpenGround()), [SCOPE])
    assert states(scene.run(5)) == ["idle"]
    scene.mission.goto([FAR])
    assert states(scene.run(60, arrived)) == ["inspecting", "driving", "arrived"]


def test_what_comes_into_view_only_at_the_last_goal_is_inspected_before_arrival_is_said() -> None:
    """It sees the object when it has turned as the goal asks; the detections come when it stands there already."""
    goal, thing = Goal("turned", Pose2D(2, 0, math.pi / 2)), Thing(1.12, 1.8)
    scene = Scene(Mission(SETTINGS, OpenGround()), [thing])
    scene.mission.goto([goal])
    rows = scene.run(90, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    assert len(results(rows)) == 1
    back = rows[max(i for i, row in enumerate(rows) if inspecting(row.step)) + 1 :]
    there = [row.stamp_ns for row in back if row.step.progress and row.step.progress.state is State.ARRIVED]
    assert there[-1] - there[0] == round(SETTINGS.last_look_s * 1e9)
    assert abs(scene.base.pose.theta - goal.pose.theta) < 2 * goal.heading_tolerance


def test_a_stop_ends_an_inspection_which_is_made_up_for_after_resume() -> None:
    scene = drive_by(SCOPE, answering=False)
    scene.run(60, asks)
    scene.mission.stop("operator")
    (result,) = results(scene.run(1))
    assert (result.picture, result.reason, result.note) == (None, "stopped: operator", "stopped: operator")
    scene.mission.resume()
    scene.answering = True
    rows = scene.run(90, arrived)
    assert states(rows) == ["driving", "inspecting", "driving", "arrived"]
    (result,) = results(rows)
    assert result.picture is not None


def test_a_stop_after_the_picture_was_taken_keeps_it_and_the_object_counts_as_visited() -> None:
    scene = drive_by(SCOPE)
    scene.run(60, asks)
    scene.run(2)
    scene.mission.stop("operator")
    (result,) = results(scene.run(1))
    assert result.picture is not None
    assert (result.reason, result.note) == ("", "stopped: operator")
    scene.mission.resume()
    assert states(scene.run(60, arrived)) == ["driving", "arrived"]


def test_a_stop_before_it_stood_leaves_a_result_that_says_that_it_never_did() -> None:
    scene = drive_by(SCOPE)
    scene.run(60, inspecting)
    scene.mission.stop("operator")
    row = scene.run(1)[0]
    assert row.step.state is MissionState.STOPPED
    assert row.step.result is not None
    assert row.step.result.stood_ns is None


@pytest.mark.parametrize(
    "detection",
    [
        seen(SCOPE, Pose2D(), -1),
        seen(SCOPE, Pose2D(), 5 * S + 1),
        replace(seen(SCOPE, Pose2D(), 4 * S), position_m=(math.nan, 0.0)),
    ],
    ids=["before the poses", "after them", "of no place"],
)
def test_a_detection_that_cannot_be_placed_is_dropped_and_counted(detection) -> None:
    mission = Mission(MissionConfig(confirm_frames=1), OpenGround())
    mission.goto([FAR])
    for stamp_ns in range(0, 5 * S, TICK_NS):
        mission.step(stamp_ns, None, Pose2D())
    step = mission.step(5 * S, None, Pose2D(), [detection])
    assert (step.state, mission.unplaced_detections) == (MissionState.DRIVING, 1)
