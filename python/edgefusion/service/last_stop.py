# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The last stop that a robot is sent when the process that drove it is dead."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Iterable, Mapping

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.pioneer_connect import HOST_BAUDS
from edgefusion.drivers.pioneer_line import PioneerLine
from edgefusion.drivers.pioneer_motion import STOP
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.drivers.sip import Message
from edgefusion.drivers.sip_status import Status
from edgefusion.errors import RefusedError

WITHIN_NS = 2_000_000_000
"""So long it tries where nothing is more urgent."""

_HOLDER = "the supervisor, which stops the robot"
_ANSWER_S = 0.25
"""A robot reports every 100 ms, which takes 93 ms at 9600 baud."""
_TRIES, _RETRY_S, _BUSY_NS = 2, 0.01, 500_000_000

_REPEATED = STOP * 12
"""More than the 255 bytes that a robot may wait for: its last packet may have been cut off when its sender died, right
before the count, and takes what comes next for that."""


@dataclass(frozen=True)
class RobotLine:
    """Where a robot is, and at which speed its line was last."""

    port: str
    baudrate: int


def robot_line(status: Mapping[str, Any]) -> RobotLine | None:
    """As a process says it in its beats; None where it names no port. A network has no speed.

    Raises RefusedError for what is no line.
    """
    port, baudrate = status.get("port"), status.get("baudrate")
    if port is None:
        return None
    if not isinstance(port, str) or not port:
        raise RefusedError(f"port: expected the name of a port, got {port!r}")
    if "://" in port:
        return RobotLine(port, HOST_BAUDS[0])
    if baudrate not in HOST_BAUDS:
        raise RefusedError(f"baudrate: expected one of {', '.join(map(str, HOST_BAUDS))}, got {baudrate!r}")
    return RobotLine(port, int(baudrate))


def stop_robot(
    where: RobotLine,
    by_ns: int | None = None,
    clock: Clock = system_clock,
    pause: Callable[[float], None] = time.sleep,
    lock_folder: Path | None = None,
) -> int:
    """Tells it to stop, at the speed that its line had and, where no report comes, at the others.

    The speed at which it reported after that. by_ns: not later than then. Raises RuntimeError where nothing came, or
    the port is gone; PortBusyError where somebody else has the robot; RefusedError for what is no port.
    """
    link = Link(where.port, where.baudrate, _HOLDER, clock=clock, lock_folder=lock_folder)
    deadline_ns = clock() + WITHIN_NS if by_ns is None else by_ns
    try:
        _open(link, deadline_ns, clock, pause)
        line = PioneerLine(link, clock, pause)
        for baudrate in _speeds(line, where.baudrate):
            if _stops(line, baudrate, baudrate == where.baudrate, deadline_ns):
                return baudrate
            if clock() >= deadline_ns:
                break
    except LinkError as error:
        raise RuntimeError(str(error)) from error
    finally:
        link.close()
    raise RuntimeError(f"{where.port}: told to stop, but it does not report")


def _open(link: Link, deadline_ns: int, clock: Clock, pause: Callable[[float], None]) -> None:
    """Waits for a port to come back, and briefly for whoever is about to let go of it."""
    busy_until_ns = min(deadline_ns, clock() + _BUSY_NS)
    while True:
        try:
            return link.open()
        except PortBusyError:
            if clock() >= busy_until_ns:
                raise
        except LinkError:
            if clock() >= deadline_ns:
                raise
        pause(_RETRY_S)


def _speeds(line: PioneerLine, known: int) -> Iterable[int]:
    """The one that it should have more often: a report may be lost."""
    if line.is_socket:
        return [known] * _TRIES
    return [known] * _TRIES + [baudrate for baudrate in HOST_BAUDS if baudrate != known]


def _stops(line: PioneerLine, baudrate: int, is_known: bool, deadline_ns: int) -> bool:
    """Whether it reports after it was told. At a speed that is only guessed it is told briefly at first."""
    if baudrate != line.link.baudrate:
        line.switch(baudrate)
    line.send(*_REPEATED if is_known else STOP)
    left_s = (deadline_ns - line.clock()) / 1e9
    if line.first(_is_status, min(_ANSWER_S, left_s)) is None:
        return False
    line.send(*_REPEATED)
    return True


def _is_status(message: Message) -> bool:
    return isinstance(message, Status)
