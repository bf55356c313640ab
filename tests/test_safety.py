# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the safety gate promises, on a clock that is a number: nothing moves without what it needs to move safely."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.config import BaseConfig, SafetyConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.braking import stoppable_speed
from edgefusion.navigation.safety import Action, Decision, SafetyGate, Stamps, judge_health, permitted_speed_mps
from edgefusion.types import Health, HealthState, Twist2D

MS = 1_000_000
BASE, SAFETY = BaseConfig(), SafetyConfig()
OK, STARTING, DEGRADED, FAILED = HealthState
WELL = (Health("robot", OK), Health("laser", OK))
GO = Twist2D(0.4, 0.2)
STILL = Twist2D()


@dataclass
class Bench:
    """Steps a gate at 20 Hz; everything is captured 10 ms before each step unless it is told otherwise."""

    gate: SafetyGate = field(default_factory=lambda: SafetyGate(SAFETY, BASE))
    now_ns: int = 10_000 * MS
    health: tuple = WELL

    def step(self, command: Twist2D = GO, after_ms: int = 50, **stamps: int | None) -> Decision:
        """One cycle; stamps: what was captured then, None for never."""
        self.now_ns += after_ms * MS
        fresh = dict.fromkeys(Stamps._fields, self.now_ns - 10 * MS)
        return self.gate.step(self.now_ns, self.health, Stamps(**{**fresh, **stamps}), command)

    def steps(self, n: int, **arguments) -> list[Decision]:
        return [self.step(**arguments) for _ in range(n)]


def running() -> Bench:
    bench = Bench()
    assert bench.steps(5)[-1].action is Action.RUN
    return bench


def test_it_starts_in_stop_and_goes_only_after_five_good_scans() -> None:
    decisions = Bench().steps(6)
    assert [decision.action for decision in decisions] == [Action.STOP] * 4 + [Action.RUN] * 2
    assert all(decision.twist == STILL for decision in decisions[:4])
    assert "scan: waiting for 5 fresh in a row" in decisions[3].reason
    assert decisions[4] == (Action.RUN, GO, ())


def test_the_first_step_stops_even_where_one_scan_is_enough() -> None:
    bench = Bench(SafetyGate(SafetyConfig(good_scans=1), BASE))
    first, second = bench.steps(2)
    assert (first.action, first.twist) == (Action.STOP, STILL)
    assert second.action is Action.RUN


@pytest.mark.parametrize(
    ("source", "limit_ms", "reason"),
    [
        ("scan_ns", 750, "scan: older than 0.75 s"),
        ("odometry_ns", 250, "odometry: older than 0.25 s"),
        ("command_ns", 300, "command: older than 0.3 s"),
    ],
)
def test_what_is_older_than_its_limit_stops_with_its_name_and_what_is_just_as_old_does_not(
    source: str, limit_ms: int, reason: str
) -> None:
    bench = running()
    stuck_ns = bench.now_ns + 50 * MS
    bench.step(**{source: stuck_ns})
    while bench.now_ns < stuck_ns + limit_ms * MS:
        assert bench.step(**{source: stuck_ns}).action < Action.STOP
    assert bench.step(after_ms=1, **{source: stuck_ns}) == (Action.STOP, STILL, ((Action.STOP, reason),))


def test_old_detections_are_noted_and_driving_goes_on() -> None:
    bench = running()
    old_ns = bench.now_ns
    decision = bench.steps(40, detections_ns=old_ns)[-1]
    assert (decision.action, decision.twist) == (Action.RUN, GO)
    assert decision.reason == "detections: older than 1.5 s"
    assert bench.step(detections_ns=None).action is Action.RUN


@pytest.mark.parametrize("source", ["scan_ns", "odometry_ns", "command_ns"])
def test_what_never_came_or_comes_from_the_future_stops(source: str) -> None:
    name = source[: -len("_ns")]
    assert running().step(**{source: None}).findings == ((Action.STOP, f"{name}: none yet"),)
    bench = running()
    decision = bench.step(**{source: bench.now_ns + 51 * MS})
    assert decision == (Action.STOP, STILL, ((Action.STOP, f"{name}: stamp of the future"),))
    assert bench.step(**{source: 2**63}).reason.startswith(f"{name}: stamp of the future")


def test_after_a_gap_of_the_scans_five_good_ones_are_wanted_again() -> None:
    bench = running()
    assert bench.step(scan_ns=None).action is Action.STOP
    assert [decision.action for decision in bench.steps(5)] == [Action.STOP] * 4 + [Action.RUN]


def test_the_same_scan_again_is_no_good_scan() -> None:
    bench = Bench()
    same_ns = bench.now_ns
    assert {decision.action for decision in bench.steps(10, scan_ns=same_ns)} == {Action.STOP}


def test_scans_slower_than_the_gate_arm_it_too() -> None:
    """5 Hz, 0.2 s old on arrival: the newest is 0.2 to 0.4 s old."""
    bench = Bench()
    actions = [bench.step(scan_ns=(bench.now_ns // (200 * MS) - 1) * 200 * MS).action for _ in range(40)]
    armed = actions.index(Action.RUN)
    assert 16 <= armed <= 20
    assert set(actions[armed:]) == {Action.RUN}


@pytest.mark.parametrize("after_ms", [201, 5000, -1])
def test_a_late_cycle_stops_and_nothing_from_before_counts_any_more(after_ms: int) -> None:
    bench = running()
    late = bench.step(after_ms=after_ms)
    assert (late.action, late.twist) == (Action.STOP, STILL)
    assert "cycle: not within 0.2 s of the last" in late.reason
    actions = [decision.action for decision in bench.steps(5)]
    assert actions[:3] == [Action.STOP] * 3
    assert actions[-1] is Action.RUN
    assert bench.step(after_ms=200).action is Action.RUN


@pytest.mark.parametrize(
    ("report", "action"),
    [
        (Health("laser", FAILED, "no telegram"), Action.STOP),
        (Health("laser", STARTING, "waiting for the port"), Action.STOP),
        (Health("laser", DEGRADED, "1 % of the telegrams broken"), Action.RUN),
        (Health("robot", STARTING, "opening the port"), Action.STOP),
        (Health("robot", FAILED, "bumper pressed"), Action.STOP_LATCHED),
        (Health("camera", FAILED, "unplugged"), Action.RUN),
        (Health("vision", STARTING, "loading the model"), Action.RUN),
        (Health("bus", FAILED, "router gone"), Action.RUN),
        (Health("gripper", FAILED, "jammed"), Action.STOP),
    ],
)
def test_a_components_health_has_its_reaction_and_says_why(report: Health, action: Action) -> None:
    bench = running()
    bench.health = (*(well for well in WELL if well.component != report.component), report)
    decision = bench.step()
    assert decision == (
        action,
        GO if action is Action.RUN else STILL,
        ((action, f"{report.component}: {report.reason}"),),
    )


def test_a_required_component_that_does_not_report_stops() -> None:
    bench = running()
    bench.health = (Health("robot", OK), Health("camera", OK))
    assert bench.step().findings == ((Action.STOP, "laser: no report yet"),)


def test_a_stop_ends_with_its_cause_and_a_latched_one_does_not() -> None:
    bench = running()
    bench.health = (Health("laser", FAILED, "no telegram"), Health("robot", OK))
    bench.step()
    bench.health = WELL
    assert bench.step().action is Action.RUN

    bench.health = (Health("laser", OK), Health("robot", FAILED, "e-stop"))
    bench.step()
    bench.health = WELL
    for decision in bench.steps(100):
        assert decision == (Action.STOP_LATCHED, STILL, ((Action.STOP_LATCHED, "robot: e-stop"),))


def test_resume_leaves_a_latched_stop_but_only_with_what_comes_after_it() -> None:
    bench = running()
    bench.gate.stop("operator: stop")
    assert bench.step().findings == ((Action.STOP_LATCHED, "operator: stop"),)
    bench.gate.resume()
    assert {decision.action for decision in bench.steps(4)} == {Action.STOP}
    assert bench.step().action is Action.RUN


def test_a_command_from_before_the_resume_does_not_drive_after_it() -> None:
    bench = Bench(SafetyGate(SafetyConfig(good_scans=1), BASE))
    bench.steps(2)
    bench.gate.stop("operator: stop")
    before_ns = bench.now_ns
    bench.step(command_ns=before_ns)
    bench.gate.resume()
    assert bench.step(command_ns=before_ns).findings == ((Action.STOP, "command: waiting for a new one"),)
    assert bench.step().action is Action.RUN


def test_resume_while_the_cause_lasts_latches_anew_and_without_a_latch_changes_nothing() -> None:
    bench = running()
    bench.gate.resume()
    assert bench.step().action is Action.RUN
    bench.health = (Health("laser", OK), Health("robot", FAILED, "bumper pressed"))
    bench.step()
    bench.gate.resume()
    assert bench.step().action is Action.STOP_LATCHED
    bench.health = WELL
    assert bench.step().action is Action.STOP_LATCHED


def test_a_latched_stop_names_the_cause_that_came_first() -> None:
    bench = running()
    bench.gate.stop("operator: stop")
    bench.health = (Health("laser", OK), Health("robot", FAILED, "bumper pressed"))
    assert bench.step().reason == "robot: bumper pressed; operator: stop"
    bench.health = WELL
    assert bench.step().reason == "operator: stop"


def test_an_operators_stop_beats_a_stop_that_is_already_there_and_outlasts_it() -> None:
    bench = Bench()
    bench.gate.stop("operator: stop")
    decision = bench.step(scan_ns=None)
    assert decision.action is Action.STOP_LATCHED
    assert decision.reason.startswith("operator: stop; ")
    assert {decision.action for decision in bench.steps(20)} == {Action.STOP_LATCHED}


@pytest.mark.parametrize(
    ("command", "passed"),
    [
        (Twist2D(5, 0), Twist2D(0.5, 0)),
        (Twist2D(-1, 0.5), Twist2D(-0.5, 0.25)),
        (Twist2D(0.3, 4 * math.radians(60)), Twist2D(0.075, math.radians(60))),
        (Twist2D(0.5, -math.radians(60)), Twist2D(0.5, -math.radians(60))),
    ],
)
def test_a_command_over_the_limit_is_slowed_down_on_its_arc_and_counted_once(command: Twist2D, passed: Twist2D) -> None:
    bench = running()
    decision = bench.step(command, command_ns=bench.now_ns)
    assert (decision.twist.v_mps, decision.twist.w_radps) == pytest.approx((passed.v_mps, passed.w_radps))
    over = command != passed
    assert decision.action is (Action.CAP if over else Action.RUN)
    assert decision.reason == ("command: faster than the base may go" if over else "")
    bench.step(command, command_ns=bench.now_ns - 50 * MS)
    assert bench.gate.over_limit == over


def test_the_older_the_scan_the_slower_and_on_the_same_arc() -> None:
    bench, fast = running(), Twist2D(0.5, 0.25)
    old_ns = bench.now_ns
    decisions = bench.steps(15, command=fast, scan_ns=old_ns)
    speeds = [decision.twist.v_mps for decision in decisions]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] == 0.5 > speeds[-1] > 0.4
    assert decisions[-1].findings == ((Action.CAP, "scan: too old for this speed"),)
    assert decisions[-1].twist.w_radps == pytest.approx(decisions[-1].twist.v_mps / 2)


@given(st.floats(0, 0.75), st.floats(0.05, 5), st.floats(0.1, 4), st.floats(0, 1))
def test_age_reaction_and_braking_fit_into_the_stopping_room(
    age_s: float, room_m: float, braking_mps2: float, delay_s: float
) -> None:
    safety = SafetyConfig(stopping_room_m=room_m)
    base = BaseConfig(acceleration_mps2=braking_mps2, command_delay_s=delay_s)
    speed_mps = permitted_speed_mps(age_s, safety, base)
    way_m = speed_mps * (age_s + 0.05 + delay_s) + speed_mps**2 / (2 * braking_mps2)
    assert speed_mps > 0
    assert way_m == pytest.approx(room_m)


def test_without_room_nothing_is_slow_enough() -> None:
    assert stoppable_speed(0, 0.1, 1) == stoppable_speed(-1, 0.1, 1) == stoppable_speed(0, 0, 1) == 0
    assert stoppable_speed(2, 0, 1) == 2


def test_the_worst_action_wins_in_whatever_order_the_reports_come() -> None:
    reports = (
        Health("camera", FAILED, "black"),
        Health("laser", FAILED, "covered"),
        Health("robot", FAILED, "stalled"),
        Health("bus", DEGRADED, "slow"),
    )
    for order in permutations(reports):
        bench = running()
        bench.health = order
        decision = bench.step(scan_ns=None)
        assert (decision.action, decision.twist) == (Action.STOP_LATCHED, STILL)
        assert decision.findings[0] == (Action.STOP_LATCHED, "robot: stalled")
        actions = [finding.action for finding in decision.findings]
        assert actions == sorted(actions, reverse=True)
        assert len(actions) == 5


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"max_cycle_s": 0.05}, "max_cycle_s: expected more than cycle_s, 0.05, got 0.05"),
        ({"optional": ("camera", "laser")}, "optional: expected none that is required or latching, got laser"),
        ({"good_scans": 0}, "good_scans: "),
        ({"max_scan_age_s": math.inf}, "max_scan_age_s: "),
        ({"required": ("",)}, "required: "),
    ],
)
def test_settings_that_contradict_themselves_are_refused(settings: dict, message: str) -> None:
    with pytest.raises(RefusedError, match=message):
        SafetyConfig(**settings)


def test_health_names_its_component_and_says_why_it_is_not_well() -> None:
    with pytest.raises(ValueError, match="reason: expected why laser is failed, got none"):
        Health("laser", FAILED)
    with pytest.raises(ValueError, match="component: expected a name"):
        Health("", OK)
    assert judge_health((replace(WELL[0], reason="fine"), WELL[1]), SAFETY) == []
