# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One drive to a goal, from the request to its end; who interrupts it calls it off."""

from __future__ import annotations

import signal
import sys
import time
from contextlib import contextmanager
from typing import Callable, Iterator, Optional, Sequence

from edgefusion.bus.client import ENDS, Errand, Robot
from edgefusion.bus.requests import GoalRequest
from edgefusion.bus.session import UnreachableError
from edgefusion.errors import RefusedError
from edgefusion.messages.mission_report import MissionReport
from edgefusion.tools.terminal import drop_stdout

ARRIVED, SILENT, ELSEWHERE, INTERRUPTED = 0, 1, 3, 130
STOPS = 3
"""So often a robot is told to stop that does not answer: a bus that was gone is back after some seconds."""

RESUMING_S, AGAIN_S = 3.0, 0.2
"""So long a robot may take until its motors are on after a stop; meanwhile it is asked again and again."""


def leave_stop(robot: Robot) -> None:
    """Before a new goal. Those that are left are given up first: else the robot would set out to them meanwhile.

    Raises RefusedError where the robot will not, UnreachableError where it does not answer.
    """
    robot.stop("a new goal is coming", cancel=True)
    robot.resume()


def drive(
    robot: Robot,
    goal: GoalRequest,
    inspect: Optional[Sequence[str]],
    show: Callable[[MissionReport], None],
    patience_s: float = 0.0,
) -> int:
    """Until the mission ends. Returns the exit code. show: is given each report; where it raises OSError, nobody sees
    how it goes, and that is as good as an interruption. patience_s: so long a robot may refuse.

    Raises RefusedError where the robot will not, UnreachableError where it does not answer or falls silent.
    """
    last = None
    try:
        for last in robot.progress(_accepted(robot, goal, inspect, patience_s)):
            show(last)
    except (KeyboardInterrupt, SystemExit):
        return _call_off(robot, "its operator interrupted the drive")
    except UnreachableError:
        raise
    except OSError as error:
        drop_stdout()
        return _call_off(robot, f"nobody reads how it goes: {error.strerror}")
    if last is None:
        raise UnreachableError("the connection was closed before the robot had arrived")
    return _code(last)


def _accepted(robot: Robot, goal: GoalRequest, inspect: Optional[Sequence[str]], patience_s: float) -> Errand:
    end_s = time.monotonic() + patience_s
    while True:
        try:
            return robot.goto_all([goal], inspect)
        except RefusedError:
            if time.monotonic() >= end_s:
                raise
        time.sleep(AGAIN_S)


def _code(last: MissionReport) -> int:
    if last.state == "arrived":
        return ARRIVED
    why = last.reason or ("its goals were given up" if last.state in ENDS else "it was given another goal")
    print(f"edgefusion: goto: did not arrive: {last.state}: {why}", file=sys.stderr)
    return ELSEWHERE


def _call_off(robot: Robot, reason: str) -> int:
    """Whatever else is pressed: the robot is told to stop."""
    with _undisturbed():
        trouble = _stop(robot, reason)
    if trouble is not None:
        print(f"edgefusion: goto: NOT called off, the robot may still drive: {trouble}", file=sys.stderr)
        return SILENT
    print("edgefusion: goto: called off: the robot stands until `edgefusion resume`", file=sys.stderr)
    return INTERRUPTED


def _stop(robot: Robot, reason: str) -> Optional[Exception]:
    """Why it was not told to; None where it was."""
    trouble: Optional[Exception] = None
    for _ in range(STOPS):
        try:
            robot.stop(reason, cancel=True)
        except (UnreachableError, RefusedError) as error:
            trouble = error
        else:
            return None
    return trouble


@contextmanager
def _undisturbed() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
