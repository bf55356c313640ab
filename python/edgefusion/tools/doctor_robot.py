# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the robot answers and could be driven. It is told nothing but to stop, and its motors are not enabled."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Callable, Iterator, List

import msgspec

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_info import RobotInfo
from edgefusion.drivers.pioneer_judgement import Judgement
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.errors import RefusedError
from edgefusion.tools.doctor_finding import END_IT, HOLDER, Examination, Finding, State
from edgefusion.types import HealthState, Twist2D

_LISTENS_S = 1.0
_LEAST_SHARE = 0.8
"""Of the reports that come at the robot's own pace."""

_SILENT = (
    "look at its power; the cable (straight) and the plug (the host's); whether [robot] port and [laser] port are "
    "swapped: docs/wiring.md"
)
_LINE = "look at the cable and what else uses the line"
_CURES = {
    HealthState.FAILED: "mend that; the robot would not drive",
    HealthState.DEGRADED: "charge it",
}


def check_robot(
    exam: Examination, clock: Clock = system_clock, pause: Callable[[float], None] = time.sleep
) -> Iterator[Finding]:
    """Listens to it for a second."""
    if not exam.runs("base"):
        yield Finding("robot", State.SKIPPED, "base runs on another machine")
    elif exam.config.robot.port in exam.unusable:
        yield Finding("robot", State.SKIPPED, "its port cannot be used")
    else:
        yield _examined(exam, clock, pause)


def _examined(exam: Examination, clock: Clock, pause: Callable[[float], None]) -> Finding:
    settings = msgspec.structs.replace(exam.config.robot, enable_motors=False, sonar=False)
    link = Link(settings.port, settings.baudrates[0], HOLDER, clock=clock, lock_folder=exam.lock_folder)
    try:
        with Pioneer(link, settings, exam.config.base, clock, pause) as robot:
            robot.start()
            assert robot.info is not None
            skipped = robot.line.reader.finder.skipped_bytes
            info, states = robot.info, _heard(robot, clock)
            noise_bytes = robot.line.reader.finder.skipped_bytes - skipped
    except LinkError as error:
        return Finding("robot", State.FAILED, str(error), _SILENT)
    except PortBusyError as error:
        return Finding("robot", State.FAILED, str(error), END_IT)
    except RefusedError as error:
        return Finding("robot", State.FAILED, str(error), "set what is named in the section [robot]")
    return _judged(exam, info, states, noise_bytes)


def _heard(robot: Pioneer, clock: Clock) -> List[RobotState]:
    states: List[RobotState] = []
    end_ns = clock() + round(_LISTENS_S * 1e9)
    while clock() < end_ns:
        states += robot.poll()
    return states


def _judged(exam: Examination, info: RobotInfo, states: List[RobotState], noise_bytes: int) -> Finding:
    name, pace_hz = _name(info), 1e9 / info.cycle_ns
    if len(states) < _LEAST_SHARE * pace_hz * _LISTENS_S:
        text = f"{name}: expected {pace_hz:g} reports a second, got {len(states) / _LISTENS_S:g}"
        return Finding("robot", State.FAILED, text, _LINE)
    judgement = Judgement(exam.config.robot, info.limits)
    # As if its motors were on: nobody has switched them on yet.
    health = [judgement.judge(replace(state, motors_enabled=True), Twist2D()) for state in states][-1]
    if health.state is not HealthState.OK:
        state = State.FAILED if health.state is HealthState.FAILED else State.WARNING
        return Finding("robot", state, f"{name}: {health.reason}", _CURES[health.state])
    if noise_bytes:
        return Finding("robot", State.WARNING, f"{name}: {noise_bytes} bytes a second of noise on its line", _LINE)
    return Finding("robot", State.OK, f"{name}, {states[-1].battery_v:.1f} V, {len(states)} reports a second")


def _name(info: RobotInfo) -> str:
    line = "over the network" if info.baudrate is None else f"{info.baudrate} baud"
    firmware = f", firmware {info.firmware}" if info.firmware else ""
    return f"{info.identity.name}: {info.identity.type} {info.identity.subtype}{firmware}, {line}"
