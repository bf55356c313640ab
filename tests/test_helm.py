# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who is at the helm: goals, driving by hand and stops, in simulated time."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from base_scenes import Bench, S, stands
from edgefusion.bus.arbiter import Arbiter
from edgefusion.bus.requests import GoalRequest, GotoRequest, InspectRequest, StopRequest
from edgefusion.errors import RefusedError
from edgefusion.messages.frames import BASE_LINK
from edgefusion.messages.to_goal_pose import GoalPose
from edgefusion.navigation.mission_step import MissionState
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.base_reports import mission_report
from edgefusion.service.goal_requests import goals_of
from edgefusion.service.helm import Helm
from edgefusion.types import Pose2D, Twist2D

AHEAD = GotoRequest((GoalRequest(1.0, 0.0, id="ahead"),))
BACK = Twist2D(-0.1, 0.0)


class Steered(Bench):
    """A bench with somebody at the helm."""

    def __init__(self, operator_timeout_ns: int | None = None) -> None:
        super().__init__()
        self.helm = Helm(self.loop, Arbiter(S // 5, operator_timeout_ns))

    @property
    def now_ns(self) -> int:
        return self.simulation.stamp_ns

    def tick(self, *arguments: int) -> Outputs:
        # The bench asks the loop; the helm is asked right before.
        step = self.loop.step
        self.loop.step = lambda now_ns, inputs: step(now_ns, _with(inputs, self.helm.twist(now_ns)))
        try:
            return super().tick(*arguments)
        finally:
            self.loop.step = step


def _with(inputs, twist):
    return replace(inputs, twist=twist)


def underway() -> Steered:
    bench = Steered()
    bench.run(1)
    bench.helm.goto(AHEAD)
    assert bench.run(1.5)[-1].command.v_mps > 0.2
    return bench


def test_a_cmd_vel_is_driven_instead_of_the_mission_and_then_the_robot_stands() -> None:
    bench = underway()
    bench.helm.cmd_vel(bench.now_ns, BACK)
    outputs = bench.run(0.2)
    assert {each.command for each in outputs} == {BACK}
    assert outputs[-1].paused
    assert stands(bench.run(1)[2:])


def test_after_resume_the_mission_goes_on_to_its_goal() -> None:
    bench = underway()
    bench.helm.cmd_vel(bench.now_ns, BACK)
    bench.run(1)
    bench.helm.resume(bench.now_ns)
    outputs = bench.run(8)
    assert not outputs[0].paused
    assert outputs[-1].mission.state is MissionState.ARRIVED


def test_a_resume_right_after_a_cmd_vel_gives_the_robot_back_to_the_mission() -> None:
    bench = underway()
    bench.helm.cmd_vel(bench.now_ns, BACK)
    bench.helm.resume(bench.now_ns)
    outputs = bench.run(0.5)
    assert not outputs[0].paused
    assert outputs[-1].command.v_mps > 0.1


def test_a_stop_is_told_with_its_reason_and_no_cmd_vel_moves_the_robot() -> None:
    bench = underway()
    bench.helm.cmd_vel(bench.now_ns, BACK)
    bench.run(0.2)
    bench.helm.stop(StopRequest("look out"))
    bench.helm.cmd_vel(bench.now_ns, BACK)
    outputs = bench.run(0.5)
    assert stands(outputs)
    report = mission_report(outputs[-1])
    assert (report.state, report.reason, report.paused) == ("stopped", "look out", False)


def test_where_the_goal_is_is_told_while_it_drives_and_while_it_is_stopped_and_not_when_it_is_given_up() -> None:
    bench = underway()
    assert mission_report(bench.outputs[0]).goal_m is None
    assert mission_report(bench.outputs[-1]).goal_m == (1.0, 0.0)
    bench.helm.stop(StopRequest("look out"))
    assert mission_report(bench.run(0.5)[-1]).goal_m == (1.0, 0.0)
    bench.helm.stop(StopRequest("enough", cancel=True))
    assert mission_report(bench.run(0.5)[-1]).goal_m is None


def test_a_stop_without_a_reason_is_a_stop() -> None:
    bench = underway()
    bench.helm.stop(StopRequest(""))
    outputs = bench.run(0.5)
    assert stands(outputs[2:])
    assert mission_report(outputs[-1]).reason == StopRequest().reason


def test_a_stop_that_cancels_leaves_nothing_to_drive_to() -> None:
    bench = underway()
    bench.helm.stop(StopRequest("enough", cancel=True))
    bench.run(1)
    bench.helm.resume(bench.now_ns)
    outputs = bench.run(1)
    assert stands(outputs)
    assert outputs[-1].mission.state is MissionState.IDLE


def test_without_the_operator_who_is_required_it_stands_until_one_is_there_and_resumes() -> None:
    bench = Steered(operator_timeout_ns=S // 2)
    bench.run(1)
    bench.helm.goto(AHEAD)
    assert stands(bench.run(1))
    with pytest.raises(RefusedError, match="no operator has been there"):
        bench.helm.resume(bench.now_ns)
    bench.helm.heartbeat(bench.now_ns)
    bench.helm.resume(bench.now_ns)
    assert not stands(bench.run(0.5))
    assert stands(bench.run(0.5)[2:])


def test_a_goal_pose_relative_to_the_robot_is_placed_where_it_is_now() -> None:
    bench = underway()
    here = bench.loop.pose
    bench.helm.goal_pose(GoalPose(BASE_LINK, Pose2D(0.5)))
    outputs = bench.run(8)
    assert outputs[-1].mission.state is MissionState.ARRIVED
    assert abs(outputs[-1].pose.x_m - here.x_m - 0.5) < 0.06


def test_a_goal_pose_that_is_refused_is_counted() -> None:
    bench = Steered()
    bench.helm.goal_pose(GoalPose(BASE_LINK, Pose2D(0.5)))
    assert bench.helm.refused_goals == 1


def test_a_goal_for_a_robot_that_is_well_and_has_not_said_where_it_is_is_refused() -> None:
    bench = Steered()
    bench.mute.add("robot")
    bench.run(1)
    with pytest.raises(RefusedError, match="has not said yet where it is"):
        bench.helm.goto(AHEAD)


def test_a_stop_before_the_robot_has_said_where_it_is_is_told_and_holds_when_it_has() -> None:
    bench = Steered()
    bench.mute.add("robot")
    bench.run(0.2)
    assert mission_report(bench.outputs[-1]).state == "idle"
    bench.helm.stop(StopRequest("not yet"))
    bench.run(0.2)
    bench.mute.clear()
    bench.run(1)
    told = [(each.pose is None, mission_report(each)) for each in bench.outputs[4:]]
    assert {unplaced for unplaced, _ in told} == {True, False}
    assert {(report.state, report.reason) for _, report in told} == {("stopped", "not yet")}


def test_interest_that_comes_with_a_goal_or_alone_is_the_missions_from_then_on() -> None:
    bench = underway()
    bench.helm.inspect(InspectRequest(("chair",)))
    bench.helm.goto(GotoRequest((GoalRequest(1.0, 0.0),), ("table", "instrument")))
    assert stands(bench.run(8)[-10:])  # with interest it looks around at the end, and arrives all the same
    assert bench.outputs[-1].mission.state is MissionState.ARRIVED


def test_a_goal_without_a_direction_is_arrived_at_in_any() -> None:
    any_way, there = goals_of(GotoRequest((GoalRequest(1, 2), GoalRequest(1, 2, 0.5, heading_tolerance=0.2))), None)
    assert any_way.heading_tolerance == math.pi
    assert (there.pose, there.heading_tolerance) == (Pose2D(1, 2, 0.5), 0.2)
    assert any_way.id != there.id


def test_a_goal_relative_to_a_robot_that_has_not_reported_is_refused() -> None:
    with pytest.raises(RefusedError, match="expected a robot that has reported"):
        goals_of(GotoRequest((GoalRequest(1, 2, frame="base_link"),)), None)
