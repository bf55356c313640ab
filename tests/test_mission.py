# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The mission drives to its goals, whatever becomes of them, and does what its operator says."""

from __future__ import annotations

import math

import pytest

from edgefusion.config import MissionConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.types import Goal, Pose2D, Twist2D
from mission_scenes import OpenGround, Scene, Thing, arrived, inspecting, results, seen, states

SETTINGS = MissionConfig()
BLIND = MissionConfig(interest=())
AHEAD = Goal("ahead", Pose2D(2, 0, 0.5))
LEFT = Goal("left", Pose2D(1, 1.5, math.pi / 2))
SCOPE = Thing(3.0, 0.8)


def scene(*things: Thing, settings: MissionConfig = SETTINGS, navigator: OpenGround | None = None) -> Scene:
    return Scene(Mission(settings, navigator or OpenGround()), things)


def assert_at(pose: Pose2D, goal: Goal) -> None:
    off = pose.relative_to(goal.pose)
    assert math.hypot(off.x_m, off.y_m) < 2 * goal.position_tolerance_m
    assert abs(off.theta) < 2 * goal.heading_tolerance


@pytest.mark.parametrize(
    "bad",
    [
        {"interest": ("",)},
        {"confirm_frames": 0},
        {"same_place_m": 0.0},
        {"facing_tolerance": 4.0},
        {"stand_s": 61.0},
        {"last_look_s": -1.0},
        {"picture_s": math.inf},
    ],
)
def test_settings_that_cannot_be_are_refused_by_name(bad) -> None:
    (name,) = bad
    with pytest.raises(RefusedError, match=f"{name}: "):
        MissionConfig(**bad)


def test_without_a_goal_it_is_idle_and_stands() -> None:
    rows = scene(SCOPE).run(3)
    assert states(rows) == ["idle"]
    assert {row.step.twist for row in rows} == {Twist2D()}


def test_told_to_stand_it_stands_whatever_the_navigator_would_do() -> None:
    class Restless(OpenGround):
        def step(self, *args):
            return Twist2D(0.1, 0.1), super().step(*args)[1]

    drive = scene(navigator=Restless())
    drive.mission.goto([AHEAD])
    drive.mission.stop("operator")
    assert {row.step.twist for row in drive.run(1)} == {Twist2D()}


def test_it_drives_to_its_goals_in_their_order() -> None:
    drive = scene()
    drive.mission.goto([AHEAD, LEFT])
    rows = drive.run(60, arrived)
    assert states(rows) == ["driving", "arrived"]
    first = [row.step.goal_id for row in rows].index("left")
    assert {row.step.goal_id for row in rows[:first]} == {"ahead"}
    assert {row.step.goal_id for row in rows[first:]} == {"left"}
    assert_at(rows[first].pose, AHEAD)
    assert_at(drive.base.pose, LEFT)


def test_the_progress_is_that_of_the_goal_as_its_operator_named_it() -> None:
    drive = scene()
    drive.mission.goto([AHEAD])
    assert {row.step.progress.goal_id for row in drive.run(3) if row.step.progress} == {"ahead"}


def test_a_goal_at_which_the_robot_is_already_is_reached_after_a_last_look_without_moving() -> None:
    drive = scene()
    drive.mission.goto([Goal("here", Pose2D())])
    rows = drive.run(5, arrived)
    assert states(rows) == ["driving", "arrived"]
    assert rows[-1].stamp_ns - rows[0].stamp_ns == round(SETTINGS.last_look_s * 1e9)
    assert {row.step.twist for row in rows} == {Twist2D()}


def test_who_looks_for_nothing_needs_no_last_look() -> None:
    drive = scene(settings=BLIND)
    drive.mission.goto([Goal("here", Pose2D())])
    assert states(drive.run(1)) == ["arrived"]


def test_a_list_without_goals_and_an_id_twice_are_refused_and_change_nothing() -> None:
    drive = scene()
    drive.mission.goto([AHEAD])
    with pytest.raises(RefusedError, match=r"goals: expected at least one, got none"):
        drive.mission.goto([])
    with pytest.raises(RefusedError, match=r"goals: expected a different id for each, got left, left"):
        drive.mission.goto([LEFT, LEFT])
    drive.run(30, arrived)
    assert_at(drive.base.pose, AHEAD)


def test_new_goals_replace_those_that_are_left() -> None:
    drive = scene()
    drive.mission.goto([AHEAD, Goal("never", Pose2D(9, 9))])
    drive.run(2)
    drive.mission.goto([LEFT])
    rows = drive.run(60, arrived)
    assert {row.step.goal_id for row in rows} == {"left"}
    assert_at(drive.base.pose, LEFT)


@pytest.mark.parametrize("driven_s", [2, 60], ids=["on the way", "there"])
def test_the_same_id_in_another_list_is_another_goal(driven_s: float) -> None:
    drive = scene()
    drive.mission.goto([AHEAD])
    drive.run(driven_s, arrived)
    drive.mission.goto([Goal("ahead", LEFT.pose)])
    drive.run(60, arrived)
    assert_at(drive.base.pose, LEFT)


def test_new_goals_let_an_inspection_that_is_under_way_end_first() -> None:
    drive = scene(SCOPE)
    drive.mission.goto([Goal("far", Pose2D(5, 0))])
    drive.run(10, inspecting)
    drive.mission.goto([LEFT])
    rows = drive.run(60, arrived)
    assert states(rows) == ["inspecting", "driving", "arrived"]
    (result,) = results(rows)
    assert result.picture is not None
    assert_at(drive.base.pose, LEFT)


def test_a_stop_is_answered_by_the_next_step_and_holds_until_resume() -> None:
    drive = scene()
    drive.mission.goto([AHEAD])
    drive.run(2)
    assert drive.base.twist.v_mps > 0.3
    drive.mission.stop("operator")
    rows = drive.run(5)
    assert {(row.step.state, row.step.reason, row.step.twist) for row in rows} == {
        (MissionState.STOPPED, "operator", Twist2D())
    }
    assert drive.base.twist == Twist2D()
    drive.mission.resume()
    assert states(drive.run(30, arrived)) == ["driving", "arrived"]
    assert_at(drive.base.pose, AHEAD)


def test_the_first_reason_to_stop_stays() -> None:
    mission = Mission(SETTINGS, OpenGround())
    mission.stop("laser lost")
    mission.stop("operator")
    assert (mission.state, mission.reason) == (MissionState.STOPPED, "laser lost")
    mission.resume()
    assert (mission.state, mission.reason) == (MissionState.IDLE, "")


def test_goals_given_to_a_stopped_mission_are_driven_to_after_resume() -> None:
    drive = scene()
    drive.mission.goto([AHEAD])
    drive.mission.stop("operator")
    drive.mission.goto([LEFT])
    rows = drive.run(2)
    assert states(rows) == ["stopped"]
    assert {row.step.twist for row in rows} == {Twist2D()}
    drive.mission.resume()
    drive.run(60, arrived)
    assert_at(drive.base.pose, LEFT)


def test_a_stop_after_the_last_goal_leaves_nothing_to_resume_to() -> None:
    drive = scene()
    drive.mission.goto([AHEAD])
    drive.run(60, arrived)
    drive.mission.stop("operator")
    drive.mission.resume()
    assert states(drive.run(1)) == ["idle"]


def test_a_stop_without_a_reason_and_a_resume_without_a_stop_are_refused() -> None:
    mission = Mission(SETTINGS, OpenGround())
    with pytest.raises(RefusedError, match=r"reason: expected why to stop, got nothing"):
        mission.stop("")
    with pytest.raises(RefusedError, match=r"resume: expected a mission that is stopped, got one that is idle"):
        mission.resume()


def test_blocked_carries_the_navigators_reason_and_ends_the_list() -> None:
    drive = scene(navigator=OpenGround(jams=lambda goal: goal.id.startswith("ahead")))
    drive.mission.goto([AHEAD, LEFT])
    rows = drive.run(2)
    assert {(row.step.state, row.step.reason, row.step.twist) for row in rows} == {
        (MissionState.BLOCKED, "goal enclosed", Twist2D())
    }
    drive.mission.goto([LEFT])
    assert states(drive.run(60, arrived)) == ["driving", "arrived"]
    assert_at(drive.base.pose, LEFT)


def test_the_navigator_sees_every_step_also_while_the_robot_stands() -> None:
    navigator = OpenGround()
    drive = scene(SCOPE, navigator=navigator)
    drive.run(1)
    drive.mission.goto([AHEAD])
    drive.run(60, arrived)
    drive.mission.stop("operator")
    drive.run(1)
    assert navigator.stamps_ns == [row.stamp_ns for row in drive.rows]


def test_a_step_that_is_not_after_the_last_is_refused_and_changes_nothing() -> None:
    mission = Mission(SETTINGS, OpenGround())
    mission.goto([AHEAD])
    first = mission.step(100, None, Pose2D())
    with pytest.raises(RefusedError, match=r"stamp_ns: expected more than 100, got 100"):
        mission.step(100, None, Pose2D(), [seen(SCOPE, Pose2D(), 0)])
    assert mission.unplaced_detections == 0
    assert mission.step(101, None, Pose2D()) == first


def test_the_same_inputs_give_the_same_steps() -> None:
    def twists() -> list[MissionStep]:
        drive = scene(SCOPE)
        drive.mission.goto([AHEAD])
        return [(row.step.twist, row.step.state, row.step.note, row.step.request) for row in drive.run(40)]

    assert twists() == twists()
