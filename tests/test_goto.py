# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion goto`, `stop` and `resume` as an operator runs them, on a real bus."""

from __future__ import annotations

import io
import json
import math
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from itertools import groupby
from pathlib import Path
from typing import Any, Callable, List, Optional

import pytest
from msgspec.structs import replace

from bus_base import LIMITS, Base, report
from bus_lab import Lab, make_keys, until
from edgefusion.bus import topics
from edgefusion.bus.freshness import Freshness
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.requests import GoalRequest, GotoRequest, ResumeRequest, StopRequest
from edgefusion.bus.session import UnreachableError
from edgefusion.cli import main
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.mission_report import InspectionReport, MissionReport
from edgefusion.tools.goto_drive import STOPS, drive

INSPECTED = InspectionReport(
    id="i1", label="oscilloscope", group="instrument", score=0.9, distance_m=1.2, place_m=(3.0, 1.0),
    pose=(2.0, 1.0, 0.0), begun_ns=1, stood_ns=2, ended_ns=3, picture_ns=2,
)  # fmt: skip


@pytest.fixture
def base(lab: Lab) -> Base:
    return Base(lab)


class Drives:
    """A robot that drives to a goal it was given, and ends as it is told to; it reports as the robot does, again and
    again. printed: after each report it waits until there is one more line of that: who asks for a goal listens only
    when it was accepted."""

    def __init__(self, base: Base, *reports: MissionReport, printed: Optional[Callable[[], str]] = None) -> None:
        self._base, self._reports, self._ended = base, reports, threading.Event()
        self._printed = printed
        self._thread = threading.Thread(target=self._drive, daemon=True)

    def __enter__(self) -> Drives:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()

    def _drive(self) -> None:
        until(lambda: self._ended.is_set() or self._requests(), 60)
        for each in self._reports[:-1]:
            self._tell(each)
        while not self._ended.is_set():
            self._say(self._reports[-1], self._requests()[0].goals[0].id)
            self._ended.wait(0.05)

    def _requests(self) -> List[GotoRequest]:
        return [each for each in self._base.asked if isinstance(each, GotoRequest)]

    def _tell(self, report: MissionReport) -> None:
        """How an inspection ended is told once."""
        before = self._lines()
        self._say(report, self._requests()[0].goals[0].id)
        while self._printed is not None and self._lines() == before and not self._ended.wait(0.05):
            if report.result is None:
                self._say(report, self._requests()[0].goals[0].id)

    def _lines(self) -> int:
        return 0 if self._printed is None else self._printed().count("\n")

    def _say(self, said: MissionReport, goal_id: str) -> None:
        named = goal_id if said.goal_id == "GOAL" else said.goal_id
        self._base.say(topics.MISSION, from_mission(replace(said, goal_id=named)))


def printed() -> str:
    """By goto in this process so far, while capsys captures it; it stays there."""
    captured = sys.stdout
    assert isinstance(captured, io.TextIOWrapper) and isinstance(captured.buffer, io.BytesIO)
    return captured.buffer.getvalue().decode()


DRIVING = replace(report(2000, "driving", "GOAL"), pose=(1.0, 2.0, math.pi / 2), way_left_m=3.5)
ARRIVED = replace(report(3000, "arrived"), pose=(5.0, 5.5, 0.26))


def test_goto_tells_how_it_goes_until_the_robot_has_arrived(
    lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]
) -> None:
    with Drives(base, DRIVING, replace(DRIVING, result=INSPECTED), ARRIVED, printed=printed):
        assert main(["goto", "5", "-5.5", "-15deg", "--inspect", "oscilloscope", "--connect", lab.tcp]) == 0
    (request,) = base.asked
    (goal,) = request.goals
    assert (goal.x_m, goal.y_m, goal.theta, goal.frame) == (5.0, -5.5, math.radians(-15), "odom")
    assert request.inspect == ("oscilloscope",)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("driving, goal ") and "3.50 m left, at x 1.00 m, y 2.00 m, 90 deg" in lines[0]
    assert lines[1] == "inspected oscilloscope at x 3.00 m, y 1.00 m: has a picture"
    assert lines[2] == "arrived, at x 5.00 m, y 5.50 m, 15 deg"
    assert len(lines) == 3


def test_goto_as_json_gives_each_report_as_the_robot_made_it(
    lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]
) -> None:
    with Drives(base, DRIVING, ARRIVED, printed=printed):
        assert main(["goto", "1", "0", "--relative", "--json", "--connect", lab.tcp]) == 0
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [state for state, _ in groupby(each["state"] for each in told)] == ["driving", "arrived"]
    assert told[0]["pose"] == [1.0, 2.0, math.pi / 2]
    assert base.asked[0].goals[0].frame == "base_link"


@pytest.mark.parametrize(
    ("last", "said"),
    [
        (replace(report(3000, "blocked"), reason="no way to the goal"), "blocked: no way to the goal"),
        (report(3000, "idle"), "idle: its goals were given up"),
        (report(3000, "driving", "somebody's"), "driving: it was given another goal"),
    ],
)
def test_a_robot_that_does_not_arrive_has_an_exit_code_of_its_own(
    lab: Lab, base: Base, capsys: pytest.CaptureFixture[str], last: MissionReport, said: str
) -> None:
    with Drives(base, DRIVING, last):
        assert main(["goto", "5", "5", "--connect", lab.tcp]) == 3
    assert capsys.readouterr().err == f"edgefusion: goto: did not arrive: {said}\n"


def test_a_robot_that_refuses_says_why(lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]) -> None:
    base.refusal = "stopped: bumped"
    assert main(["goto", "5", "5", "--connect", lab.tcp]) == 2
    assert capsys.readouterr().err == "edgefusion: robot/mission/goto: refused: stopped: bumped\n"


class Starting(Base):
    """Its motors are not on yet when it is asked for the first time."""

    def _answer(self, request: Any) -> None:
        self.refusal = "the motors are off" if isinstance(request, GotoRequest) and not self.refusal else ""
        super()._answer(request)


def test_after_a_resume_a_robot_may_take_its_time_until_it_can_drive(lab: Lab) -> None:
    base = Starting(lab)
    with Drives(base, DRIVING, ARRIVED):
        assert main(["goto", "5", "5", "--resume", "--connect", lab.tcp]) == 0
    assert [type(each) for each in base.asked] == [StopRequest, ResumeRequest, GotoRequest]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_who_interrupts_goto_calls_the_robot_off(lab: Lab, base: Base, number: signal.Signals) -> None:
    command = [sys.executable, "-m", "edgefusion.cli", "goto", "5", "5", "--connect", lab.tcp]
    with Drives(base, DRIVING), subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("driving")
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err == "edgefusion: goto: called off: the robot stands until `edgefusion resume`\n"
    assert base.asked[1:] == [StopRequest("its operator interrupted the drive", True)]


class Slow(Base):
    """It answers its first request when it is told to."""

    def __init__(self, lab: Lab) -> None:
        super().__init__(lab)
        self.go_on = threading.Event()

    def _answer(self, request: Any) -> None:
        super()._answer(request)
        self.go_on.wait(60)


def test_a_goto_that_is_ended_before_it_set_out_has_not_arrived(lab: Lab) -> None:
    base = Slow(lab)
    command = [sys.executable, "-m", "edgefusion.cli", "goto", "5", "5", "--resume", "--connect", lab.tcp]
    with subprocess.Popen(command) as process:
        until(lambda: base.asked, 60)
        process.send_signal(signal.SIGTERM)
        base.go_on.set()
        assert process.wait(60) == 130
    assert [type(each) for each in base.asked] == [StopRequest]


def test_where_nobody_reads_how_it_goes_any_more_the_robot_is_called_off(lab: Lab, base: Base) -> None:
    command = [sys.executable, "-m", "edgefusion.cli", "goto", "5", "5", "--json", "--connect", lab.tcp]
    with Drives(base, DRIVING), subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        assert '"driving"' in process.stdout.readline()
        process.stdout.close()  # as `| head -1` does
        err = process.stderr.read()
    assert process.returncode == 130
    assert err == "edgefusion: goto: called off: the robot stands until `edgefusion resume`\n"
    assert base.asked[1:] == [StopRequest("nobody reads how it goes: Broken pipe", True)]


class Deaf:
    """A robot that is interrupted, and whose bus is gone for so many requests."""

    def __init__(self, deaf_for: int) -> None:
        self.deaf_for, self.stops = deaf_for, 0

    def goto_all(self, *_: object) -> None:
        pass

    def progress(self, _: object) -> None:
        raise KeyboardInterrupt

    def stop(self, reason: str, cancel: bool) -> None:
        self.stops += 1
        if self.stops <= self.deaf_for:
            raise UnreachableError("nobody answered")


def test_a_robot_that_does_not_answer_is_told_to_stop_again(capsys: pytest.CaptureFixture[str]) -> None:
    robot = Deaf(STOPS - 1)
    assert drive(robot, GoalRequest(1, 2), None, lambda _: None) == 130
    assert robot.stops == STOPS
    assert "called off: the robot stands" in capsys.readouterr().err


def test_who_could_not_call_the_robot_off_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert drive(Deaf(99), GoalRequest(1, 2), None, lambda _: None) == 1
    err = capsys.readouterr().err
    assert err == "edgefusion: goto: NOT called off, the robot may still drive: nobody answered\n"


class Attended(Base):
    """Notes with each request how many heartbeats of an operator had come."""

    def __init__(self, lab: Lab) -> None:
        super().__init__(lab)
        self.beats: List[int] = []
        self._inbox = Inbox(self.session, "robot", topics.HEARTBEAT, lambda message: message.data, Freshness(LIMITS))

    def _answer(self, request: Any) -> None:
        self.beats.append(self._inbox.waiting)
        super()._answer(request)


def test_an_operator_is_there_before_goto_asks_for_anything(lab: Lab) -> None:
    base = Attended(lab)
    with Drives(base, DRIVING, ARRIVED):
        assert main(["goto", "5", "5", "--resume", "--connect", lab.tcp]) == 0
    assert [type(each) for each in base.asked] == [StopRequest, ResumeRequest, GotoRequest]
    assert base.asked[0].cancel  # else it would set out to its former goals as soon as it may
    assert min(base.beats) >= 1


def test_stop_and_resume_ask_the_robot_for_just_that(lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stop", "--connect", lab.tcp]) == 0
    assert main(["stop", "--cancel", "--reason", "a cat", "--connect", lab.tcp]) == 0
    assert main(["resume", "--connect", lab.tcp]) == 0
    assert base.asked == [StopRequest("asked by an operator"), StopRequest("a cat", True), ResumeRequest()]
    assert capsys.readouterr().out.splitlines()[-1] == "resumed"


@pytest.mark.parametrize("verb", [["stop"], ["resume"], ["goto", "1", "2"]])
def test_where_nobody_answers_it_is_said_in_one_line(
    lab: Lab, capsys: pytest.CaptureFixture[str], verb: list[str]
) -> None:
    begun_s = time.monotonic()
    assert main([*verb, "--connect", lab.tcp]) == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "nobody answered: is the base running" in err
    assert time.monotonic() - begun_s < 60


def test_with_an_operator_s_keys_goto_goes_over_the_network(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    keys = make_keys(tmp_path / "keys")
    with ExitStack() as stack:
        lab = Lab(stack, keys)
        lab.router()
        base = Base(lab)
        monkeypatch.setenv("EDGEFUSION_KEYS", str(keys / "operator"))
        with Drives(base, DRIVING, ARRIVED):
            assert main(["goto", "5", "5", "--connect", lab.tls]) == 0
    assert [type(each) for each in base.asked] == [GotoRequest]
    assert capsys.readouterr().out.splitlines()[-1].startswith("arrived, at x 5.00 m")


@pytest.mark.parametrize("heading", ["15", "15 deg", "deg", "nandeg", "1e3deg"])
def test_a_heading_without_its_unit_is_refused(heading: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["goto", "1", "2", heading])
    assert "expected an angle as 15deg or 0.26rad" in capsys.readouterr().err
