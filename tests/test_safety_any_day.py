# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whatever is said to the safety gate in whatever order, it keeps what it promises."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule

from edgefusion.config import BaseConfig, SafetyConfig
from edgefusion.navigation.safety import Action, Decision, SafetyGate, Stamps
from edgefusion.types import Health, HealthState, Twist2D

MS = 1_000_000
BASE, SAFETY = BaseConfig(), SafetyConfig()
OK, STARTING, DEGRADED, FAILED = HealthState
WELL = (Health("robot", OK), Health("laser", OK))
GO, STILL = Twist2D(0.4, 0.2), Twist2D()


class AnyDay(RuleBasedStateMachine):
    """Each step is held against a plain account of what the gate was told."""

    def __init__(self) -> None:
        super().__init__()
        self.gate, self.now_ns = SafetyGate(SAFETY, BASE), 0
        self.stamps: dict[str, int | None] = dict.fromkeys(Stamps._fields)
        self.reports = {well.component: well for well in WELL}
        self.latched = False
        self.scans: set[int] = set()  # fresh ones since the last reason to distrust them
        self.command = GO

    @rule(source=st.sampled_from(Stamps._fields), age_ms=st.integers(-300, 1000))
    def something_comes(self, source: str, age_ms: int) -> None:
        self.stamps[source] = self.now_ns - age_ms * MS

    @rule(v=st.floats(-2, 2), w=st.floats(-3, 3))
    def another_command(self, v: float, w: float) -> None:
        self.command = Twist2D(v, w)

    @rule(component=st.sampled_from(["robot", "laser", "camera", "bus"]), state=st.sampled_from(HealthState))
    def a_component_reports(self, component: str, state: HealthState) -> None:
        self.reports[component] = Health(component, state, "" if state is OK else "as it is")

    @rule()
    def the_operator_stops(self) -> None:
        self.gate.stop("operator: stop")
        self.latched = True

    @rule()
    def the_operator_resumes(self) -> None:
        if self.latched:
            self.scans = set()
        self.gate.resume()
        self.latched = False

    @rule(after_ms=st.integers(0, 400))
    def time_passes(self, after_ms: int) -> None:
        self.step(after_ms)

    @rule(n=st.integers(1, 12))
    def all_is_well_for_a_while(self, n: int) -> None:
        self.reports = {well.component: well for well in WELL}
        for _ in range(n):
            self.stamps = dict.fromkeys(Stamps._fields, self.now_ns + 40 * MS)
            decision = self.step(50)
        if n >= SAFETY.good_scans and not self.latched:
            assert decision.action in (Action.RUN, Action.CAP)

    def step(self, after_ms: int) -> Decision:
        self.now_ns += after_ms * MS
        decision = self.gate.step(self.now_ns, tuple(self.reports.values()), Stamps(**self.stamps), self.command)
        self.latched |= self.reports["robot"].state is FAILED
        if after_ms > 200 or not self.is_fresh("scan_ns", 750):
            self.scans = set()
        if self.is_fresh("scan_ns", 750):
            self.scans.add(self.stamps["scan_ns"])
        assert (decision.action is Action.STOP_LATCHED) is self.latched
        assert decision.action is max((finding.action for finding in decision.findings), default=Action.RUN)
        if decision.action >= Action.STOP:
            assert decision.twist == STILL
        else:
            self.check_that_it_may_move(after_ms)
            self.check_speed(decision)
        return decision

    def check_that_it_may_move(self, after_ms: int) -> None:
        assert after_ms <= 200
        assert len(self.scans) >= SAFETY.good_scans
        assert self.is_fresh("odometry_ns", 250)
        assert self.is_fresh("command_ns", 300)
        for component in self.reports.keys() - {"camera"}:
            assert self.reports[component].state in (OK, DEGRADED)

    def check_speed(self, decision: Decision) -> None:
        v_mps, w_radps = decision.twist.v_mps, decision.twist.w_radps
        assert abs(v_mps) <= BASE.max_speed_mps * (1 + 1e-9)
        assert abs(w_radps) <= BASE.max_yaw_rate_radps * (1 + 1e-9)
        assert v_mps * self.command.w_radps == pytest.approx(w_radps * self.command.v_mps)
        assert (decision.action is Action.RUN) is (decision.twist == self.command)

    def is_fresh(self, source: str, limit_ms: int) -> bool:
        stamp_ns = self.stamps[source]
        return stamp_ns is not None and 0 <= self.now_ns - stamp_ns <= limit_ms * MS


TestAnyDay = AnyDay.TestCase
TestAnyDay.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
