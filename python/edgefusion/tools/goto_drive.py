# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One drive to a goal, from the request to its end; who interrupts it calls it off."""

from __future__ import annotations

import signal
import sys
from contextlib import contextmanager
from typing import Callable, Iterator, Optional, Sequence

from edgefusion.bus.client import ENDS, Robot
from edgefusion.bus.requests import GoalRequest
from edgefusion.bus.session import UnreachableError
from edgefusion.messages.mission_report import MissionReport

ARRIVED, ELSEWHERE, INTERRUPTED = 0, 3, 130


def drive(
    robot: Robot, goal: GoalRequest, inspect: Optional[Sequence[str]], show: Callable[[MissionReport], None]
) -> int:
    """Until the mission ends. Returns the exit code. show: is given each report.

    Raises RefusedError where the robot will not, UnreachableError where it does not answer or falls silent.
    """
    last = None
    try:
        for last in robot.progress(robot.goto_all([goal], inspect)):
            show(last)
    except (KeyboardInterrupt, SystemExit):
        return _call_off(robot)
    if last is None:
        raise UnreachableError("the connection was closed before the robot had arrived")
    return _code(last)


def _code(last: MissionReport) -> int:
    if last.state == "arrived":
        return ARRIVED
    why = last.reason or ("its goals were given up" if last.state in ENDS else "it was given another goal")
    print(f"edgefusion: goto: did not arrive: {last.state}: {why}", file=sys.stderr)
    return ELSEWHERE


def _call_off(robot: Robot) -> int:
    """Whatever else is pressed: the robot is told to stop."""
    with _undisturbed():
        robot.stop("its operator interrupted the drive", cancel=True)
    print("edgefusion: goto: called off: the robot stands until `edgefusion resume`", file=sys.stderr)
    return INTERRUPTED


@contextmanager
def _undisturbed() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
