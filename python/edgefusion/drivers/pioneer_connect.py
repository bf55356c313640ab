# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From a Pioneer in any state to an open session: the speed of its line, the handshake, its parameters."""

from __future__ import annotations

from typing import Iterable

from edgefusion.drivers.pioneer_line import PioneerLine, RobotError
from edgefusion.drivers.sip import Message
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_config import AUTOBAUD_RESETS, Identity, RobotConfig, read_identity
from edgefusion.drivers.sip_frame import Packet, frame
from edgefusion.drivers.sip_status import Status
from edgefusion.errors import RefusedError

HOST_BAUDS = (9600, 19200, 38400, 57600, 115200)
"""In the order of HOSTBAUD's argument."""

REPLY_S = 0.3
"""A reply of 30 bytes takes 31 ms at 9600 baud, and a robot up to a cycle to send it."""

_SILENT_TRIES, _TRIES, _CONFIG_TRIES = 2, 12, 3
_SETTLE_S, _LEAVES_S = 0.1, 0.02
"""The second: until the last byte is on the line, though an adapter took it before."""
_FIRST_STATUS_S, _NEW_SPEED_S = 1.0, 0.9


def find(line: PioneerLine, baudrates: Iterable[int]) -> Identity:
    """Tries the speed that the line has, then the others; a network has none. The robot is synchronized then, not yet
    open.

    At each speed it is told to stop before anything else: an earlier session may have left it driving.
    Raises RobotError where it answers at none of them.
    """
    current = line.link.baudrate
    tried = [current] if line.is_socket else search_order(current, baudrates)
    for baudrate in tried:
        line.switch(baudrate)
        identity = _synchronized(line)
        if identity is not None:
            return identity
    speeds = ", ".join(str(baudrate) for baudrate in dict.fromkeys(tried))
    where = "" if line.is_socket else f" at any of {speeds} baud"
    raise RobotError(f"{line.link.name}: expected a Pioneer, got no answer{where}")


def search_order(current: int, baudrates: Iterable[int]) -> list[int]:
    """The current speed, then the others; between them the first again and again: there a robot listens that is just
    being switched on, which shall not have to wait for all the others."""
    home, *others = dict.fromkeys(baudrates)
    order = [current] if current == home else [current, home]
    for baudrate in others:
        if baudrate != current:
            order += [baudrate, home]
    return order


def _synchronized(line: PioneerLine) -> Identity | None:
    """None where it is silent at this speed. Raises RobotError for one that answers, but does not get through."""
    line.send(command(Command.STOP))
    step = silent = 0
    for _ in range(_TRIES):
        line.send(frame(bytes([step])))
        reply = line.first(_any, REPLY_S)
        if reply is None:
            silent, step = silent + 1, 0
            if silent == _SILENT_TRIES:
                return None
            line.send(command(Command.OPEN, 1))  # to one whose handshake ended, but that nobody opened: it is silent
            continue
        silent = 0
        identity = _identity(reply) if step == 2 else None
        if identity is not None:
            return identity
        step = _next_step(line, step, reply)
    raise RobotError(f"{line.link.name}: the robot answers, but in {_TRIES} tries its handshake came to no end")


def _next_step(line: PioneerLine, step: int, reply: Message) -> int:
    """What an answer asks for: the next step, or to start again."""
    if isinstance(reply, Packet) and reply.type == step < 2:
        return step + 1
    if isinstance(reply, Status):  # an old session is still open
        line.send(command(Command.CLOSE, 1))
    line.drain(_SETTLE_S)
    return 0


def _identity(reply: Message) -> Identity | None:
    if not (isinstance(reply, Packet) and reply.type == 2):
        return None
    try:
        return read_identity(reply.body)
    except RefusedError:  # cut short
        return None


def open_session(line: PioneerLine) -> RobotConfig | None:
    """Opens it, and asks for the parameters, which old firmware has not and some robots send damaged: None then.

    Its first word in it is to stop: as long as nobody spoke to it, it kept what it was told last.
    Raises RobotError where it does not begin to report.
    """
    line.send(command(Command.OPEN, 1), command(Command.STOP))
    found = None
    for _ in range(_CONFIG_TRIES):
        line.send(command(Command.CONFIG, 1))
        found = line.first(lambda message: isinstance(message, RobotConfig), REPLY_S)
        if found is not None:
            break
    if line.first(_is_status, _FIRST_STATUS_S) is None:
        raise RobotError(f"{line.link.name}: the robot opened no session: it reports nothing")
    return found if isinstance(found, RobotConfig) else None


def go_faster(line: PioneerLine, config: RobotConfig | None, baudrate: int | None) -> None:
    """Raises the line's speed where the robot says that it comes back by itself, or it could not be found again.

    Goes back where nothing arrives at the new one. Raises LinkError, also where nothing arrives at the old one either.
    """
    before = line.link.baudrate
    resets = config is not None and config.autobaud == AUTOBAUD_RESETS
    if not resets or baudrate is None or baudrate <= before or line.is_socket:
        return
    line.send(command(Command.HOSTBAUD, HOST_BAUDS.index(baudrate)))
    line.pause(_LEAVES_S)
    for speed in (baudrate, before):
        line.switch(speed)
        line.send(command(Command.PULSE))
        if line.first(_is_status, _NEW_SPEED_S) is not None:
            return
    raise RobotError(f"{line.link.name}: the robot fell silent when its line was to change to {baudrate} baud")


def _any(message: Message) -> bool:
    return True


def _is_status(message: Message) -> bool:
    return isinstance(message, Status)
