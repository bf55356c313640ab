# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the base's loop promises, on a clock that is a number: it drives when all is well, and stops when it is not."""

from __future__ import annotations

import math

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from base_scenes import AHEAD, CONFIG, MS, TICK_NS, WELL, Bench, driving, failed, room, stands
from edgefusion.errors import RefusedError
from edgefusion.navigation.law import as_carried
from edgefusion.navigation.mission_step import MissionState
from edgefusion.navigation.safety import Action
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.base_reports import base_health
from edgefusion.types import Goal, Health, HealthState, Pose2D, Twist2D

BACK = Goal("back", Pose2D(0.0, 0.0), 0.05, math.pi)
STARTING = HealthState.STARTING


def off_m(bench: Bench, goal: Goal) -> float:
    pose = bench.simulation.pose
    return math.hypot(pose.x_m - goal.pose.x_m, pose.y_m - goal.pose.y_m)


def assert_stays(bench: Bench, seconds: float = 2.0) -> None:
    """Told nothing but zero, and so at rest in the end."""
    assert stands(bench.run(seconds))
    before = bench.simulation.pose
    bench.run(0.5)
    assert bench.simulation.pose == before


def test_it_drives_to_its_goal_and_touches_nothing() -> None:
    bench = Bench()
    bench.run(1)
    bench.loop.goto([AHEAD])
    outputs = bench.run(8)
    assert outputs[-1].mission.state is MissionState.ARRIVED
    assert off_m(bench, AHEAD) < 0.06
    assert not bench.simulation.contact


def test_without_a_goal_it_stands_and_has_nothing_to_say_against_driving() -> None:
    outputs = Bench().run(2)
    assert stands(outputs)
    assert (outputs[-1].decision.action, outputs[-1].decision.reason) == (Action.RUN, "detections: none yet")


def test_until_the_robot_has_reported_it_has_no_pose_and_stands() -> None:
    bench = Bench(mute={"robot"})
    outputs = bench.run(1)
    assert stands(outputs)
    assert {(each.pose, each.mission.state, each.session) for each in outputs} == {(None, MissionState.IDLE, None)}


def test_a_goal_before_the_first_step_is_refused() -> None:
    with pytest.raises(RefusedError, match="goal: refused: robot: no report yet; laser: no report yet"):
        BaseLoop(CONFIG).goto([AHEAD])


@pytest.mark.parametrize(
    ("health", "reason"),
    [
        (failed("robot", "the emergency stop is pressed"), "robot: the emergency stop is pressed"),
        (failed("robot", "bumped: front 3"), "robot: bumped: front 3"),
        (failed("robot", "the motors are off"), "robot: the motors are off"),
        (Health("robot", STARTING, "not started"), "robot: not started"),
        (failed("laser", "silent"), "laser: silent"),
        (Health("laser", STARTING, "not started"), "laser: not started"),
    ],
)
def test_a_goal_at_boot_is_refused_with_the_reason_and_taken_once_it_is_gone(health: Health, reason: str) -> None:
    bench = Bench(healths={**WELL, health.component: health})
    bench.run(1)
    with pytest.raises(RefusedError, match=f"goal: refused: {reason}"):
        bench.loop.goto([AHEAD])
    assert stands(bench.run(1))
    assert bench.outputs[-1].mission.state is MissionState.IDLE
    bench.mend(health.component)
    assert stands(bench.run(1))
    bench.loop.goto([AHEAD])
    assert bench.run(1.5)[-1].command.v_mps > 0.2


def test_it_drives_on_without_a_vision_that_was_given_up_and_says_that_it_is_degraded() -> None:
    bench = driving()
    assert base_health(bench.tick()) == Health("base", HealthState.OK)
    bench.others = (failed("vision", "given up after 5 failures"),)
    assert {each.command.v_mps > 0.2 for each in bench.run(1)} == {True}
    without = "drives on without vision: given up after 5 failures"
    assert base_health(bench.outputs[-1]) == Health("base", HealthState.DEGRADED, without)
    bench.fail("laser", "silent")
    assert base_health(bench.tick()) == Health("base", HealthState.DEGRADED, "scan: none yet; laser: silent")


def test_with_a_low_battery_goals_are_refused_but_the_last_is_driven_to() -> None:
    bench = driving(seconds=1.5)
    bench.changes["battery_v"] = CONFIG.robot.low_battery_v - 0.1
    bench.run(1)
    with pytest.raises(RefusedError, match=r"robot: the battery is low: 11\.4 V"):
        bench.loop.goto([BACK])
    bench.run(7)
    assert off_m(bench, AHEAD) < 0.06


@pytest.mark.parametrize("name", ["robot", "laser"])
def test_a_device_that_fails_stops_the_robot_in_the_step_that_sees_it(name: str) -> None:
    bench = driving()
    bench.fail(name, "vanished")
    output = bench.tick()
    assert output.command == Twist2D()
    assert f"{name}: vanished" in output.decision.reason


def test_after_a_failure_of_the_robot_it_stays_until_a_new_goal() -> None:
    bench = driving()
    bench.fail("robot", "vanished")
    (output,) = bench.run(0.05)
    assert (output.mission.state, output.mission.reason) == (MissionState.STOPPED, "robot: vanished")
    bench.run(1)
    bench.mend("robot")
    assert_stays(bench)
    bench.loop.goto([BACK])
    bench.run(10)
    assert off_m(bench, BACK) < 0.06


def test_a_goal_after_a_failure_of_the_robot_leaves_the_stop_once() -> None:
    bench = driving()
    bench.fail("robot", "vanished")
    bench.run(1)
    bench.mend("robot")
    bench.tick()
    bench.loop.goto([BACK])
    while bench.tick().command == Twist2D():
        pass
    bench.loop.goto([BACK])
    assert bench.tick().decision.action < Action.STOP
    with pytest.raises(RefusedError, match="resume: expected a mission that is stopped, got one that is driving"):
        bench.loop.resume()


def test_an_outage_costs_none_of_the_patience_with_a_goal() -> None:
    navigation = msgspec.structs.replace(CONFIG.navigation, patience_s=1.0)
    bench = Bench(BaseLoop(msgspec.structs.replace(CONFIG, navigation=navigation)))
    bench.run(1)
    bench.loop.goto([AHEAD])
    bench.run(1.5)
    bench.mute.add("robot")
    bench.run(3)
    bench.mute.clear()
    bench.run(7)
    assert off_m(bench, AHEAD) < 0.06


def test_a_resume_after_a_failure_of_the_robot_leads_to_none_of_the_old_goals() -> None:
    bench = driving()
    bench.fail("robot", "vanished")
    bench.run(1)
    bench.mend("robot")
    bench.loop.resume()
    assert_stays(bench)
    assert bench.outputs[-1].mission.state is MissionState.IDLE


def test_a_resume_while_the_robot_is_not_well_moves_nothing() -> None:
    bench = driving()
    bench.fail("robot", "bumped: front 1")
    bench.run(1)
    bench.loop.resume()
    assert_stays(bench)
    assert bench.outputs[-1].decision.action is Action.STOP_LATCHED


@pytest.mark.parametrize("name", ["robot", "laser"])
def test_a_failure_that_is_over_before_the_next_step_stops_all_the_same(name: str) -> None:
    bench = driving()
    bench.fail(name, "vanished for a moment")
    bench.mend(name)
    output = bench.tick()
    assert output.command == Twist2D()
    assert f"{name}: vanished for a moment" in output.decision.reason


def test_after_an_outage_of_the_laser_it_drives_on_to_its_goal_after_five_good_scans() -> None:
    bench = driving()
    bench.fail("laser", "vanished")
    bench.run(0.5)
    bench.mend("laser")
    scans_ns, go = [], None
    while go is None:
        output = bench.tick()
        scans_ns += [] if output.scan is None else [output.scan.stamp_ns]
        go = len(scans_ns) if output.command != Twist2D() else None
    assert go == CONFIG.safety.good_scans
    bench.run(8)
    assert off_m(bench, AHEAD) < 0.06


def test_a_laser_that_falls_silent_stops_the_robot_when_its_newest_scan_is_too_old() -> None:
    bench = Bench(BaseLoop(CONFIG, scan_age_limit_s=0.2))
    bench.run(1)
    bench.loop.goto([AHEAD])
    last_ns = [output.scan.stamp_ns for output in bench.run(2) if output.scan is not None][-1]
    bench.mute.add("laser")
    stopped = next(output for output in bench.run(1) if output.command == Twist2D())
    assert 200 * MS < stopped.stamp_ns - last_ns <= 200 * MS + TICK_NS
    assert "scan: older than 0.2 s" in stopped.decision.reason


def test_before_a_scan_is_too_old_the_robot_gets_slower_in_what_the_wire_carries() -> None:
    bench = driving(Goal("far", Pose2D(3.0, 0.0)))
    bench.mute.add("laser")
    outputs = bench.run(0.75)
    assert Action.CAP in {output.decision.action for output in outputs}
    assert all(output.command == as_carried(output.command) for output in outputs)
    assert all(output.scan is None for output in outputs)


def test_a_robot_that_falls_silent_is_told_to_stop_when_its_newest_report_is_too_old() -> None:
    bench = driving()
    bench.mute.add("robot")
    stopped = next(output for output in bench.run(1) if output.command == Twist2D())
    assert stopped.stamp_ns - bench.outputs[-20].stamp_ns <= 300 * MS
    assert "odometry: older than 0.25 s" in stopped.decision.reason


def test_a_cycle_that_is_late_stops_and_five_good_scans_later_it_drives_on() -> None:
    bench = driving()
    assert bench.tick(after_ns=250 * MS).command == Twist2D()
    bench.run(7)
    assert off_m(bench, AHEAD) < 0.06


def test_an_operators_stop_holds_until_resume_whatever_goals_come() -> None:
    bench = driving()
    bench.loop.stop("operator")
    output = bench.tick()
    assert (output.command, output.mission.state, output.mission.reason) == (
        Twist2D(),
        MissionState.STOPPED,
        "operator",
    )
    assert output.decision.action is Action.STOP_LATCHED
    bench.loop.goto([BACK])
    assert_stays(bench)
    bench.loop.resume()
    bench.run(10)
    assert off_m(bench, BACK) < 0.06


def test_a_failure_of_the_robot_does_not_turn_an_operators_stop_into_one_that_a_goal_leaves() -> None:
    bench = driving()
    bench.loop.stop("operator")
    bench.run(0.5)
    bench.fail("robot")
    bench.run(0.5)
    bench.mend("robot")
    bench.run(0.5)
    bench.loop.goto([BACK])
    assert_stays(bench)


def test_an_operators_stop_after_a_failure_of_the_robot_holds_against_new_goals_too() -> None:
    bench = driving()
    bench.fail("robot")
    bench.run(0.5)
    bench.mend("robot")
    bench.loop.stop("operator")
    bench.run(0.5)
    bench.loop.goto([BACK])
    assert_stays(bench)


def test_cancelled_goals_are_not_driven_to() -> None:
    bench = driving()
    bench.loop.cancel()
    assert_stays(bench)
    assert bench.outputs[-1].mission.state is MissionState.IDLE
    with pytest.raises(RefusedError, match="resume: expected a mission that is stopped, got one that is idle"):
        bench.loop.resume()


def test_a_resume_asks_once_for_motors_that_are_off() -> None:
    bench = driving()
    bench.changes["motors_enabled"] = False
    bench.fail("robot", "the motors are off")
    assert not any(output.enable_motors for output in bench.run(1))
    bench.loop.resume()
    assert [output.enable_motors for output in bench.run(0.2)] == [True, False, False, False]


def test_a_resume_of_a_robot_whose_motors_are_on_does_not_ask_for_them() -> None:
    bench = driving()
    bench.loop.stop("operator")
    bench.run(0.5)
    bench.loop.resume()
    assert not any(output.enable_motors for output in bench.run(0.5))


def test_between_reports_the_pose_is_carried_on_with_the_velocity_of_the_newest() -> None:
    bench = driving()
    for output in bench.run(0.5):
        there = bench.truth.at(output.stamp_ns)
        assert math.hypot(output.pose.x_m - there.x_m, output.pose.y_m - there.y_m) < 0.002


def test_every_scan_is_handed_out_once() -> None:
    scans = [output.scan for output in driving().run(1.5) if output.scan is not None]
    assert len(scans) >= 25
    assert [scan.stamp_ns for scan in scans] == sorted({scan.stamp_ns for scan in scans})


def test_the_same_inputs_give_the_same_commands() -> None:
    assert [each.command for each in driving().outputs] == [each.command for each in driving().outputs]


def test_a_time_that_is_not_after_the_last_is_refused() -> None:
    bench = driving()
    with pytest.raises(RefusedError, match="stamp_ns: expected more than"):
        bench.tick(after_ns=0)


def test_the_scan_age_of_the_laser_only_shortens_what_is_configured() -> None:
    safety = msgspec.structs.replace(CONFIG.safety, max_scan_age_s=0.4)
    bench = Bench(BaseLoop(msgspec.structs.replace(CONFIG, safety=safety), scan_age_limit_s=0.7), room())
    bench.run(1)
    bench.mute.add("laser")
    assert "scan: older than 0.4 s" in bench.run(0.5)[-1].decision.reason


EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["fail robot", "fail laser", "mend robot", "mend laser", "goto", "stop", "resume", "cancel"]),
        st.integers(1, 8),
    ),
    max_size=25,
)


@settings(max_examples=20)
@given(EVENTS)
def test_whatever_happens_nothing_moves_on_failed_devices_or_without_leave(events) -> None:
    bench, held = Bench(), ""
    bench.run(0.5)
    for event, ticks in events:
        held = held_after(bench, event, held)
        for _ in range(ticks):
            output = bench.tick()
            is_failed = any(health.state is HealthState.FAILED for health in bench.healths.values())
            if is_failed or held:
                assert output.command == Twist2D(), (event, held)
    assert not bench.simulation.contact


def held_after(bench: Bench, event: str, held: str) -> str:
    """Does it, and says by whom the robot is held then."""
    verb, _, name = event.partition(" ")
    if name:
        (bench.fail if verb == "fail" else bench.mend)(name)
        return held or ("robot" if event == "fail robot" else "")
    arguments = {"goto": ([AHEAD],), "stop": ("operator",)}.get(verb, ())
    try:
        getattr(bench.loop, verb)(*arguments)
    except RefusedError:
        return held
    if verb == "stop":
        return "operator"
    left = verb == "resume" or (verb == "goto" and held == "robot")
    return "" if left else held
