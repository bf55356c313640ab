# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The soak would tell: a stop that comes late, a contact, a robot that stays, a process that grows or ends."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.soak_faults import FAULTS, SoakFault
from benchmarks.soak_health import Growth, Sample, Traces
from benchmarks.soak_lives import Lives
from benchmarks.soak_report import Result, line_of, tables, tracebacks
from benchmarks.soak_run import Happened, Soak, drawn
from benchmarks.soak_told import ToldWatch

from edgefusion.drivers.sip_command import Command
from edgefusion.sim.sip_robot_commands import Told

CYCLE_S = 0.05


class VirtualRig:
    """A robot that is told something every 50 ms, in a time of its own. late_s: until it stands after a fault."""

    def __init__(self, late_s: float = 0.1, stays: bool = False) -> None:
        self.rng, self.told = np.random.default_rng(0), ToldWatch()
        self.now_s, self.contacts, self.late_s, self.stays = 1000.0, 0, late_s, stays
        self._faulty_s, self._mended, self.silent = math.inf, True, False
        self.diary: List[str] = []

    def fault(self, name: str, **facts: Any) -> SoakFault:
        return SoakFault(name, lambda _: self.break_(), lambda _: self.mend(), **facts)

    def note(self, what: str) -> None:
        self.diary.append(what)

    def break_(self) -> None:
        self._faulty_s, self._mended = self.now_s, False

    def mend(self) -> None:
        self._mended = True
        self._faulty_s = self._faulty_s if self.stays else math.inf

    @property
    def drives(self) -> bool:
        return self.told.v_mps > 0

    stands = property(lambda self: not self.drives)

    def until(self, holds: Callable[[], object], within_s: float) -> bool:
        end_s = self.now_s + within_s
        while not holds():
            if self.now_s >= end_s:
                return False
            self.now_s += CYCLE_S
            stands = self.now_s >= self._faulty_s + self.late_s
            if not (self.silent and not self._mended):
                self.told.look([(round(self.now_s * 1e9), Told(Command.VEL, 0 if stands else 300))])
        return True


def soaked(rig: VirtualRig, faults: List[SoakFault], total_s: float = 600.0) -> List[Happened]:
    soak = Soak(rig, 60.0, total_s, lambda _: None)  # type: ignore[arg-type]
    soak.run(faults)
    return soak.happened


def result(happened: List[Happened], growths: Tuple[Growth, ...] = (), wrong: Tuple[str, ...] = ()) -> Result:
    return Result(happened, growths, sum(each.touched for each in happened), wrong, {"arrived": 3})


def test_a_fault_in_every_period_of_which_the_robot_stood_in_time_is_as_it_should_be() -> None:
    rig = VirtualRig(late_s=0.1)
    happened = soaked(rig, [rig.fault("off", wanted="told", limit_s=0.2)])
    assert len(happened) == 10
    assert [each.took_s for each in happened] == [pytest.approx(0.1, abs=CYCLE_S + 0.001)] * 10
    assert result(happened).broken == result(happened).missed == []


@pytest.mark.parametrize(("late_s", "broken"), [(0.3, False), (0.9, True), (99.0, True)])
@pytest.mark.parametrize("wanted", ["told", "halted"])
def test_a_stop_that_comes_late_is_missed_and_one_that_no_load_explains_breaks_the_soak(
    late_s: float, broken: bool, wanted: Any
) -> None:
    rig = VirtualRig(late_s)
    found = result(soaked(rig, [rig.fault("off", wanted=wanted, limit_s=0.2)], 60.0))
    assert len(found.missed) == 1
    assert bool(found.broken) is broken


def test_a_robot_that_shall_drive_on_and_hears_nothing_for_a_while_is_told() -> None:
    rig = VirtualRig(late_s=math.inf)
    fault = rig.fault("bus killed", wanted="heard", limit_s=0.3)
    assert not result(soaked(rig, [fault], 60.0)).missed
    rig.silent = True
    assert len(result(soaked(rig, [fault], 60.0)).missed) == 1


def test_a_robot_that_does_not_drive_again_breaks_the_soak() -> None:
    rig = VirtualRig(stays=True)
    assert result(soaked(rig, [rig.fault("off")], 60.0)).broken == ["off at 10 s: the robot did not drive again"]


def test_what_is_touched_breaks_the_soak() -> None:
    happened = Happened(FAULTS[0], 0.0, 0.1, 1.0, touched=1)
    assert "no contact, got 1" in result([happened]).broken[0]
    assert "1 contacts" in line_of(happened)


def test_what_a_robot_touches_that_hears_nothing_is_told_apart() -> None:
    happened = Happened(FAULTS[0], 0.0, 0.1, 1.0, touched=0, unhelped=1)
    found = Result([happened], (), 1, (), {})
    assert found.broken == []
    assert "contacts: 0, and 1 while the robot heard nothing" in tables(found)


def test_what_is_early_comes_in_the_first_third_alone() -> None:
    rig = VirtualRig()
    faults = [rig.fault("killed", early=True), rig.fault("off")]
    happened = soaked(rig, faults, 1800.0)
    early_s = [each.at_s for each in happened if each.fault.early]
    assert len(early_s) == 5
    assert max(early_s) < 600.0
    assert max(each.at_s for each in happened) > 1740.0
    assert len(happened) == 30


def test_every_fault_comes_before_one_comes_again_and_a_seed_repeats_their_order() -> None:
    def first(count: int) -> List[str]:
        faults = drawn(FAULTS, np.random.default_rng(3))
        return [next(faults).name for _ in range(count)]

    assert sorted(first(len(FAULTS))) == sorted(fault.name for fault in FAULTS)
    assert first(50) == first(50)


def traced(sizes: Callable[[float], float], handles: Callable[[float], int] = lambda _: 9) -> Traces:
    """One process for half an hour."""
    traces = Traces(600.0, lambda _, at_s: Sample(at_s, sizes(at_s), handles(at_s), 4))
    for at_s in range(0, 1800, 5):
        traces.look(at_s, {"base": 7})
    return traces


def test_memory_that_a_process_takes_until_it_is_warm_is_no_growth() -> None:
    (growth,) = traced(lambda at_s: 50 + min(at_s, 600) / 60).growths()
    assert growth.rss_mb == 0
    assert growth.judged_s == pytest.approx(1195)
    assert result([], (growth,)).grown == []


def test_memory_that_is_given_back_again_is_no_growth() -> None:
    (growth,) = traced(lambda at_s: 250 if at_s > 1500 and at_s % 60 < 20 else 200).growths()
    assert growth.rss_mb == 0


@pytest.mark.parametrize(("mb_per_min", "grown", "broken"), [(0.2, 0, 0), (0.5, 1, 0), (1.5, 1, 1)])
def test_a_process_that_goes_on_growing_is_told(mb_per_min: float, grown: int, broken: int) -> None:
    (growth,) = traced(lambda at_s: 50 + at_s / 60 * mb_per_min).growths()
    found = result([], (growth,))
    assert (len(found.grown), len(found.broken)) == (grown, broken)
    assert ("grows" in tables(found)) is bool(grown)


def test_one_more_handle_is_told_and_many_break_the_soak() -> None:
    (one,) = traced(lambda _: 50, lambda at_s: 9 + (at_s > 1000)).growths()
    (many,) = traced(lambda _: 50, lambda at_s: 9 + int(at_s / 60)).growths()
    assert (len(result([], (one,)).grown), result([], (one,)).broken) == (1, [])
    assert "handles" in result([], (many,)).broken[0]


def test_a_process_that_was_started_again_is_judged_by_the_one_that_lived_longest_after_it_was_warm() -> None:
    sizes: Dict[int, float] = {1: 50.0, 2: 80.0, 3: 99.0}
    traces = Traces(600.0, lambda pid, at_s: Sample(at_s, sizes[pid], 9, 4))
    for at_s in range(0, 1800, 5):
        traces.look(at_s, {"vision": 1 if at_s < 700 else 2 if at_s < 1700 else 3})
    (growth,) = traces.growths()
    assert (growth.first.rss_mb, growth.rss_mb) == (80.0, 0.0)


def test_where_no_process_lived_long_enough_nothing_is_said_of_its_growth() -> None:
    traces = Traces(600.0, lambda _, at_s: Sample(at_s, at_s, 9, 4))
    for at_s in range(0, 700, 5):
        traces.look(at_s, {"base": 7})
    assert "lived too short" in tables(result([], tuple(traces.growths())))


def test_a_process_that_ended_by_itself_and_an_exception_in_a_log_break_the_soak(tmp_path: Path) -> None:
    assert result([], wrong=("base ended at 5 s",)).broken == ["base ended at 5 s"]
    (tmp_path / "robot.log").write_text("base: Traceback (most recent call last):\n", encoding="utf-8")
    (tmp_path / "recorder.log").write_text("all is well\n", encoding="utf-8")
    assert tracebacks(tmp_path) == ["robot.log: 1 tracebacks"]


def test_the_first_stop_after_a_time_counts_and_what_was_heard_before_does_not() -> None:
    watch = ToldWatch()
    heard = [(1, Told(Command.STOP)), (2, Told(Command.VEL, 300)), (3, Told(Command.RVEL, 5))]
    watch.look(heard)
    assert watch.stopped_s(2e-9) is None
    assert watch.v_mps == pytest.approx(0.3)
    heard += [(7, Told(Command.VEL, 0)), (9, Told(Command.E_STOP))]
    watch.look(heard)
    assert watch.stopped_s(2e-9) == pytest.approx(5e-9)
    assert watch.v_mps == 0


def test_a_process_that_was_killed_may_be_missing_for_a_while_and_ends_as_it_should_once() -> None:
    lives = Lives("camera")
    assert lives.look({"vision": 1, "base": 2, "camera": 3}) == []
    lives.doom("vision")
    assert lives.look({"vision": 1, "base": 2, "camera": 4}) == []
    assert lives.look({"base": 2}) == lives.look({"base": 2}) == []
    assert lives.look({"vision": 5, "base": 2}) == []
    assert lives.look({"vision": 6, "base": 2}) == ["vision"]
    assert lives.look({"vision": 6}) == ["base"]


def test_a_fault_without_a_limit_has_none_to_miss() -> None:
    happened = replace(Happened(FAULTS[0], 0.0, None, 1.0, 0))
    assert not happened.missed
