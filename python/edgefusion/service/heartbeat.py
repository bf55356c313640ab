# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A child's side of its line to the supervisor: signs of life go up, how the other processes are comes down.

Nothing in here waits, and nothing raises for what becomes of the supervisor: whether it hangs or is gone must not
disturb whoever drives. That it is gone the end of the line tells, and SIGTERM, which the kernel sends then.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import socket
from contextlib import suppress
from typing import Any, Dict, Mapping, MutableMapping, Tuple

import msgspec

from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError
from edgefusion.types import Health

ENVIRONMENT = "EDGEFUSION_HEARTBEAT_FD"
"""Names the file descriptor of the line, a socket that keeps messages apart."""

STOPPED = "EDGEFUSION_STOPPED"
"""Says why an operator has stopped the process that this one takes the place of, as a JSON string; unset, or of an
empty one, where none has."""

MAX_BYTES = 16_384
"""Of a message. A socket's buffer takes several."""

EVERY_NS = 100_000_000
"""A status that did not change is sent no more often."""

_PR_SET_PDEATHSIG = 1

Status = Dict[str, Any]


class Heartbeat:
    """socket_: of the kind SEQPACKET; None: nobody supervises, beats go nowhere.

    A status is a flat JSON object. Of a process that drives a robot: `port`, its port, and `baudrate`, the line's speed
    now, so that the supervisor can stop the robot, and `stopped`, why an operator has stopped it, which the process
    that takes its place finds in its own stopped. Of any: `says`, what it does, in a few words for people.
    """

    def __init__(self, socket_: socket.socket | None, clock: Clock = system_clock, stopped: str = "") -> None:
        self._socket, self._clock, self.stopped = socket_, clock, stopped
        self._sent: bytes | None = None
        self._sent_ns = 0
        self._gone = False
        self._others: Tuple[Health, ...] = ()

    @property
    def supervised(self) -> bool:
        """Whether there is, or was, a supervisor."""
        return self._socket is not None

    def beat(self, status: Mapping[str, Any] | None = None) -> None:
        """Says that the caller's loop is alive, and how it is. To be called in each of its cycles.

        Raises RefusedError for a status that is too long, TypeError for one that is no JSON.
        """
        message = msgspec.json.encode(dict(status or {}))
        if len(message) > MAX_BYTES:
            raise RefusedError(f"status: expected up to {MAX_BYTES} bytes of JSON, got {len(message)}")
        now_ns = self._clock()
        if self._socket is None or (message == self._sent and now_ns - self._sent_ns < EVERY_NS):
            return
        with suppress(OSError):  # it hangs, and has heard enough by then; or it is gone, which parent_gone() tells
            self._socket.send(message)
            self._sent, self._sent_ns = message, now_ns

    def parent_gone(self) -> bool:
        """Whether the supervisor is dead: its child is to stop the robot and end."""
        self._receive()
        return self._gone

    def others(self) -> Tuple[Health, ...]:
        """How the other processes are, as the supervisor last said."""
        self._receive()
        return self._others

    def _receive(self) -> None:
        while self._socket is not None and not self._gone:
            try:
                message = self._socket.recv(MAX_BYTES)
            except BlockingIOError:
                return
            except OSError:
                message = b""
            if not message:
                self._gone = True
                return
            self._others = msgspec.json.decode(message, type=Tuple[Health, ...])


def from_environment(environment: MutableMapping[str, str] | None = None, clock: Clock = system_clock) -> Heartbeat:
    """The line that the supervisor gave this process, which is no matter of its own children: they do not inherit it.

    For the main thread: from here on SIGTERM comes when the supervisor dies. Raises RefusedError for what is no line.
    """
    environment = os.environ if environment is None else environment
    text, stopped = environment.pop(ENVIRONMENT, None), _read(environment.pop(STOPPED, ""))
    if text is None:
        return Heartbeat(None, clock)
    line = _line(text)
    line.setblocking(False)
    os.set_inheritable(line.fileno(), False)
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM), 0, 0, 0)
    return Heartbeat(line, clock, stopped)


def carried(stopped: str) -> str:
    """As the value of STOPPED: whatever the locale, an environment takes ASCII."""
    return json.dumps(stopped)


def _read(value: str) -> str:
    with suppress(ValueError):  # by hand it may be plain
        return str(json.loads(value or '""'))
    return value


def _line(text: str) -> socket.socket:
    try:
        line = socket.socket(fileno=int(text))
    except (OSError, ValueError, OverflowError) as error:
        raise RefusedError(f"{ENVIRONMENT}: expected the supervisor's line, got {text!r}: {error}") from error
    if line.type != socket.SOCK_SEQPACKET:
        line.detach()  # it is somebody else's
        raise RefusedError(f"{ENVIRONMENT}: expected the supervisor's line, got {text!r}: another kind of socket")
    return line
