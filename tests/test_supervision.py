# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a supervisor decides, in virtual time: whom it starts, kills and gives up; the robot is stopped first."""

from __future__ import annotations

import signal
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.service.child_spec import ChildSpec, GiveUp
from edgefusion.service.supervision import END_NS, GRACE_NS, Supervision
from edgefusion.service.supervision_actions import Send, Start, StopRobot
from edgefusion.types import HealthState
from supervised import BASE, BUS, LINE, REQUIRED_VISION, VISION, S, Supervised


def test_all_are_started_at_once_and_it_is_ready_when_all_that_it_needs_have_shown_that_they_live() -> None:
    made = Supervised()
    assert made.up == ["bus", "base", "vision"]
    assert {health.state for health in made.supervision.healths()} == {HealthState.STARTING}
    made.silent = {"base", "vision"}
    made.run(1)
    assert not made.supervision.ready
    assert made.supervision.in_words() == "bus ok; base starting: starts; vision starting: starts"
    made.silent = {"vision"}
    made.turn()
    assert made.supervision.ready


def test_a_base_that_an_operator_has_stopped_is_started_again_as_one_that_is_stopped() -> None:
    made = Supervised()
    for stopped in ("there is a child", ""):
        made.statuses["base"], made.silent = {**LINE, "stopped": stopped}, set()
        made.run(10)
        made.done.clear()
        made.silent = {"base"}  # those that come next say nothing, and are killed: the stop is not lost with them
        made.die("base")
        made.run(30)
        starts = [action for _, action in made.done if isinstance(action, Start)]
        assert len(starts) > 1
        assert {start.stopped for start in starts} == {stopped}


def test_once_ready_it_stays_so() -> None:
    made = Supervised()
    made.run(1)
    made.die("base")
    assert made.supervision.ready


def test_what_a_child_says_is_told_to_people() -> None:
    made = Supervised()
    made.statuses["base"] = {"says": "drives to (5.0, 5.5)"}
    made.turn()
    assert made.supervision.in_words() == "bus ok; base ok: drives to (5.0, 5.5); vision ok"


@pytest.mark.parametrize("code", [0, 1, 2, -signal.SIGKILL, -signal.SIGSEGV])
def test_however_base_dies_the_robot_is_told_to_stop_before_base_is_started_again(code: int) -> None:
    made = Supervised()
    made.run(1)
    made.stuck = {"base"}
    died_s = made.now_s
    made.die("base", code)
    made.run(20)
    assert made.since(died_s) == [StopRobot("base", LINE, None)]
    made.supervision.robot_stopped("base", True)
    made.turn()
    assert made.up == ["bus", "vision", "base"]


def test_the_robot_is_stopped_at_the_next_turn() -> None:
    made = Supervised()
    made.run(1)
    made.die("base")
    made.turn(0)
    assert made.done[-1] == (made.now_s, StopRobot("base", LINE, None))


def test_base_is_started_again_though_nobody_knows_whether_the_robot_stopped() -> None:
    made = Supervised()
    made.robot_stops = False
    made.run(1)
    made.die("base")
    made.run(1)
    assert "base" in made.up


def test_a_base_that_dies_before_it_names_a_robot_is_stopped_where_its_predecessor_was() -> None:
    made = Supervised()
    made.run(1)
    made.statuses["base"] = {"says": "starts"}
    for _ in range(2):
        made.run(1)
        made.die("base")
    made.turn()
    assert made.done[-1][1] == StopRobot("base", LINE, None)


@pytest.mark.parametrize(("name", "limit_s"), [("bus", 3.0), ("base", 1.5), ("vision", 4.0)])
def test_who_falls_silent_is_killed_when_its_time_is_over_and_not_before(name: str, limit_s: float) -> None:
    made = Supervised()
    made.run(1)
    silent_s = made.now_s
    made.silent = {name}
    made.run(limit_s)
    assert not made.since(silent_s)
    made.silent = set()
    made.turn()
    made.silent = {name}
    made.run(limit_s + 0.1)
    assert made.since(silent_s)[0] == Send(name, signal.SIGKILL)
    assert f"{name}: silent" not in made.health(name).reason  # its name is said beside it
    assert made.health(name).reason.startswith(f"silent for {limit_s:g} s")


def test_who_shows_no_life_after_its_start_is_killed_later() -> None:
    made = Supervised(VISION)
    made.silent = {"vision"}
    made.run(60)
    assert made.up == ["vision"] and len(made.done) == 1
    made.run(0.1)
    assert made.done[1][1] == Send("vision", signal.SIGKILL)
    assert made.health("vision").reason == "no sign of life within 60 s of its start"


def test_a_pause_of_the_whole_machine_is_nobodys_silence() -> None:
    made = Supervised()
    made.run(1)
    made.silent = {"bus", "base", "vision"}  # what they said is still to be read
    made.turn(30 * S)
    assert made.up == ["bus", "base", "vision"]
    made.run(1.0)
    assert made.up == ["bus", "base", "vision"]
    made.run(0.6)
    assert [action for _, action in made.done if isinstance(action, Send)] == [Send("base", signal.SIGKILL)]


def test_who_falls_silent_after_such_a_pause_gets_no_more_time_than_usual() -> None:
    made = Supervised()
    made.run(1)
    made.turn(30 * S)
    made.silent = {"base"}
    made.run(1.6)
    assert made.done[-2][1] == Send("base", signal.SIGKILL)


def test_pauses_double_and_begin_anew_after_it_lived_for_long() -> None:
    made = Supervised(BUS)
    for _ in range(9):
        made.run(0.1)
        made.die("bus", 1)
        while not made.up:
            made.turn()
    gaps = [later - earlier for earlier, later in zip(made.starts("bus"), made.starts("bus")[1:])]
    assert gaps == pytest.approx([0.2, 0.3, 0.5, 0.9, 1.7, 3.3, 5.1, 5.1, 5.1], abs=0.01)
    made.run(11)
    died_s = made.now_s
    made.die("bus", 1)
    made.run(1)
    assert made.starts("bus")[-1] - died_s == pytest.approx(0.1, abs=0.01)


def test_a_required_child_is_started_for_ever() -> None:
    made = Supervised(BUS)
    for _ in range(100):
        made.run(0.1)
        made.die("bus", 1)
        made.run(6)
    assert made.up == ["bus"] and not made.supervision.ending


def fail_vision(made: Supervised, times: int, pause_s: float = 5.0) -> None:
    for _ in range(times):
        made.run(pause_s)
        made.die("vision", -signal.SIGSEGV)


def test_vision_is_given_up_after_five_failures_in_a_minute_and_the_rest_goes_on() -> None:
    made = Supervised()
    fail_vision(made, 4)
    made.run(5)
    assert "vision" in made.up
    made.die("vision", -signal.SIGSEGV)
    given_up_s = made.now_s
    made.run(600)
    assert made.up == ["bus", "base"] and not made.since(given_up_s)
    assert made.health("vision").state is HealthState.FAILED
    assert made.health("vision").reason == "given up after 5 failures: killed by SIGSEGV"


def test_failures_that_are_a_minute_apart_do_not_add_up() -> None:
    made = Supervised()
    fail_vision(made, 20, 15.1)
    made.run(6)
    assert "vision" in made.up


def test_without_leave_to_drive_on_all_ends_when_vision_is_given_up() -> None:
    made = Supervised(BUS, BASE, REQUIRED_VISION)
    fail_vision(made, 5)
    assert made.until_it_ends() <= 0.1
    assert made.up == [] and made.supervision.exit_code == 1


def test_the_robot_of_a_base_that_is_given_up_is_stopped_before_all_ends() -> None:
    made = Supervised(replace(BASE, give_up=GiveUp(1, 60.0)))
    made.run(1)
    made.die("base")
    made.until_it_ends()
    assert made.story == ["life", "stop"] and made.supervision.exit_code == 1
    assert made.supervision.in_words() == "base failed: given up after 1 failures: killed by SIGKILL"


def test_vision_that_cannot_be_run_is_given_up_too() -> None:
    made = Supervised(VISION, missing=["vision"])
    made.run(30)
    assert made.health("vision").reason == "given up after 5 failures: cannot be run"


@pytest.mark.parametrize("name", ["bus", "base"])
def test_a_required_child_that_refuses_to_start_ends_all_as_refused(name: str) -> None:
    made = Supervised()
    made.silent = {name}
    made.turn()
    made.die(name, 2)
    made.until_it_ends()
    assert made.supervision.exit_code == 2


def test_vision_that_refuses_to_start_does_not_end_the_rest() -> None:
    made = Supervised()
    made.silent = {"vision"}
    made.turn()
    made.die("vision", 2)
    made.run(1)
    assert made.up == ["bus", "base", "vision"]


def test_who_once_lived_and_then_refuses_is_started_again() -> None:
    made = Supervised()
    made.turn()
    made.silent = {"base"}
    for _ in range(3):
        made.run(1)
        made.die("base", 2)
    made.run(1)
    assert "base" in made.up and not made.supervision.ending


def test_asked_to_end_it_asks_all_and_has_ended_when_they_have() -> None:
    made = Supervised()
    made.run(1)
    made.supervision.end(made.clock(), "asked")
    asked_s = made.now_s
    assert made.until_it_ends() <= 0.1
    assert made.since(asked_s) == [Send(name, signal.SIGTERM) for name in ("bus", "base", "vision")]
    assert made.supervision.exit_code == 0


def test_who_does_not_end_is_killed_and_its_robot_stopped_in_time() -> None:
    made = Supervised()
    made.run(1)
    made.deaf = {"base", "vision"}
    made.supervision.end(made.clock(), "asked")
    asked_ns, asked_s = made.clock(), made.now_s
    assert made.until_it_ends() == pytest.approx(GRACE_NS / S, abs=0.11)
    assert made.since(asked_s)[3:] == [
        Send("base", signal.SIGKILL),
        Send("vision", signal.SIGKILL),
        StopRobot("base", LINE, asked_ns + END_NS),
    ]
    assert made.supervision.exit_code == 0


def test_it_ends_in_time_though_the_robots_stop_does_not_and_says_that_by_its_exit_code() -> None:
    made = Supervised()
    made.run(1)
    made.deaf = made.stuck = {"base"}
    made.supervision.end(made.clock(), "asked")
    assert made.until_it_ends() == pytest.approx(END_NS / S, abs=0.06)
    assert END_NS < 3 * S and made.supervision.exit_code == 1


def test_a_stop_that_the_robot_may_not_have_heard_shows_in_the_exit_code() -> None:
    made = Supervised()
    made.run(1)
    made.robot_stops = False
    made.supervision.end(made.clock(), "asked")
    made.die("base", 1)
    made.until_it_ends()
    assert made.supervision.exit_code == 1


def test_a_stop_that_is_under_way_is_waited_for() -> None:
    made = Supervised(BASE)
    made.run(1)
    made.stuck = {"base"}
    made.die("base")
    made.turn()
    made.supervision.end(made.clock(), "asked")
    made.run(1)
    assert not made.supervision.has_ended(made.clock())
    made.supervision.robot_stopped("base", True)
    assert made.until_it_ends() == 0 and made.supervision.exit_code == 0


def test_nobody_is_started_any_more_once_it_ends() -> None:
    made = Supervised()
    made.run(1)
    made.die("vision")
    made.supervision.end(made.clock(), "asked")
    assert made.until_it_ends() <= 0.1
    made.run(5)
    assert made.starts("vision") == [1.0] and not made.up


def test_a_second_wish_to_end_changes_nothing() -> None:
    made = Supervised()
    made.run(1)
    made.deaf = {"vision"}
    made.supervision.end(made.clock(), "asked")
    made.run(1.5)
    made.supervision.end(made.clock(), "asked again", 1)
    assert made.until_it_ends() == pytest.approx(GRACE_NS / S - 1.5, abs=0.11)
    assert made.supervision.exit_code == 0


def test_who_was_given_up_is_said_to_be_so_at_the_end_too() -> None:
    made = Supervised()
    fail_vision(made, 5)
    made.supervision.end(made.clock(), "asked")
    made.until_it_ends()
    assert made.supervision.in_words().startswith("bus failed: ended; base failed: ended; vision failed: given up")


def test_two_children_of_one_name_are_refused() -> None:
    with pytest.raises(RefusedError, match="each name once"):
        Supervision([BUS, BUS])


@pytest.mark.parametrize("wrong", [{"name": ""}, {"argv": ()}, {"start_s": 0.0}, {"silence_s": -1.0}])
def test_a_child_that_nobody_can_run_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(RefusedError, match="child"):
        ChildSpec(**{"name": "bus", "argv": ("bus",), "start_s": 1.0, "silence_s": 1.0, **wrong})


EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["die", "silent", "speak", "stuck", "stopped", "deaf", "missing", "there", "nothing"]),
        st.sampled_from(["bus", "base", "vision"]),
        st.sampled_from([0, 1, 2, -9, -11]),
        st.integers(0, 100),
    ),
    max_size=40,
)


@given(EVENTS)
def test_whatever_happens_base_never_starts_beside_itself_or_before_its_robot_was_stopped_and_all_ends_in_time(
    events: list[tuple[str, str, int, int]],
) -> None:
    made = Supervised()
    for what, name, code, turns in events:
        if what == "die" and name in made.up:
            made.die(name, code)
        elif what == "stopped" and name in made.stuck:
            made.stuck.remove(name)
            made.supervision.robot_stopped(name, bool(code))
        elif what in ("silent", "stuck", "deaf", "missing"):
            getattr(made, what).add(name)
        elif what in ("speak", "there"):
            made.silent.discard(name)
            made.missing.discard(name)
        for _ in range(turns):
            made.turn()
            assert len(set(made.up)) == len(made.up)
    made.supervision.end(made.clock(), "asked")
    assert made.until_it_ends() <= 3.0
    assert not made.up
    assert ("life", "life") not in list(zip(made.story, made.story[1:]))
