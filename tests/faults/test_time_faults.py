# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""S2, S3, S4: a wall clock that steps, a base that is halted, and one that gets no processor in time."""

from __future__ import annotations

import itertools
import time
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from threaded_base import ThreadedBase

from base_scenes import TICK_NS, driving
from edgefusion.navigation.safety import Action
from edgefusion.service.base_inputs import Outputs
from edgefusion.types import Goal, Pose2D, Twist2D

MS, S = 1_000_000, 1_000_000_000
HOUR_S, YEARS_S = 3600.0, timedelta(days=3652).total_seconds()
STEPS_S = (HOUR_S, -HOUR_S, YEARS_S, -YEARS_S, -1.0)


@pytest.fixture
def base(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """One that drives, at its seed's moment."""
    monkeypatch.locks = tmp_path
    made: list[ThreadedBase] = []

    def make(seed: int = 0) -> ThreadedBase:
        made.append(ThreadedBase(monkeypatch, seed))
        return made[-1].driving()

    yield make
    for each in made:
        assert not each.clock.errors
        each.clock.finish()


class WallClock:
    """Every reading of the wall clock is a step away from the last."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._steps, self._now_s = itertools.cycle(STEPS_S), time.time()
        monkeypatch.setattr(time, "time", self.read)
        monkeypatch.setattr(time, "time_ns", lambda: round(1e9 * self.read()))

    def read(self) -> float:
        self._now_s += next(self._steps)
        return self._now_s


def test_s2_a_wall_clock_that_steps_changes_no_command_and_ages_no_scan(base, monkeypatch: pytest.MonkeyPatch) -> None:
    """It drives, and then its laser falls silent: what is told, and when, is the same to the nanosecond."""

    def told() -> list[tuple[int, Twist2D, str]]:
        it = base()
        it.run(0.5)
        it.inject("laser=off")
        it.run(0.5)
        it.clock.finish()  # its ports are free for the next
        return [(each.stamp_ns, each.command, each.decision.reason) for each in it.outputs]

    steady = told()
    WallClock(monkeypatch)
    assert told() == steady
    assert steady[-1][1] == Twist2D()


PLACES = ("anywhere", "before the step", "after the step")


def halt(base: ThreadedBase, place: str) -> int:
    """All its threads for a second: in one of their waits, or while the loop is at its step. When they go on."""
    if place == "anywhere":
        base.run(0.05 * float(base.rng.random()))
        return base.halt(1.0)
    until_ns: list[int] = []
    step = base.loop.step

    def halted() -> None:
        if not until_ns:
            until_ns.append(base.clock() + S)
            base.halt(1.0)

    def halts(now_ns: int, inputs: object) -> Outputs:
        if place == "before the step":
            halted()
        outputs = step(now_ns, inputs)
        if place == "after the step":
            halted()
        return outputs

    base.loop.step = halts
    base.run(0.06, lambda: bool(until_ns))
    return until_ns[0]


@pytest.mark.parametrize("place", PLACES)
def test_s3_a_base_that_was_halted_says_first_to_stop_and_works_with_nothing_that_is_too_old(base, place: str) -> None:
    it = base(PLACES.index(place))
    on_ns = halt(it, place)
    it.run(2.5)
    first_ns, stands = it.motions_since(on_ns)[0]
    assert stands
    assert first_ns - on_ns <= 50 * MS
    drove = [cycle for cycle in it.cycles if cycle[1].stamp_ns >= on_ns and cycle[1].command != Twist2D()]
    print(
        place,
        [(o.stamp_ns / 1e9, o.decision.reason, o.mission.state, o.mission.reason) for o in it.outputs[-3:]],
        it.clock.errors,
    )
    assert drove, "it is well, and goes on"
    for inputs, outputs in drove:
        assert outputs.stamp_ns - inputs.laser.newest.stamp_ns <= 1e9 * it.age_limit_s
        assert outputs.stamp_ns - inputs.robot.newest.state.stamp_ns <= 250 * MS
    assert drove[0][0].laser.newest.stamp_ns > on_ns


@pytest.mark.parametrize("seed", range(4))
def test_s4_a_cycle_that_is_later_than_200_ms_stops_and_one_that_is_not_does_not(seed: int) -> None:
    rng, bench = np.random.default_rng(seed), driving(Goal("far", Pose2D(3.0, 0.0)), seconds=1.0)
    for _ in range(6):
        bench.run(0.1 * int(rng.integers(0, 8)))
        after_ns = TICK_NS * int(rng.integers(1, 9))
        output = bench.tick(after_ns)
        is_late = after_ns > 200 * MS
        assert ("cycle: not within 0.2 s of the last" in output.decision.reason) == is_late
        assert not is_late or (output.command, output.decision.action) == (Twist2D(), Action.STOP)


def test_s4_a_loop_that_gets_no_processor_at_all_finds_its_robot_stopped(base) -> None:
    """By the robot's own thread, once the loop's last command is too old; then by the loop, for its late cycle."""
    it = base()
    it.run(0.06)
    last_ns, on_ns = it.outputs[-1].stamp_ns, it.clock() + S
    it.clock.halt(S, "loop")
    it.run(1.1)
    assert next(ns for ns, stands in it.motions_since(last_ns) if stands) - last_ns <= 320 * MS
    assert it.moved_since(last_ns + 320 * MS) == []
    late = next(output for output in it.outputs if output.stamp_ns >= on_ns)
    assert "cycle: not within 0.2 s of the last" in late.decision.reason
