# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Tells systemd how the service is: that it is ready, lives, is well, ends. Without systemd it tells nobody."""

from __future__ import annotations

import logging
import os
import socket
from typing import Mapping, Set

from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError

VARIABLES = ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID")
"""Of the environment; they are not for children."""

STATUS_NS = 500_000_000
"""From one status to the next at least."""

_LOG = logging.getLogger(__name__)


class Notifier:
    """environment: as systemd sets it; a socket whose name begins with @ has no file. pid: this process'.

    Never waits; what systemd does not take is lost. Raises RefusedError for variables that systemd does not set so.
    """

    def __init__(
        self, environment: Mapping[str, str] | None = None, clock: Clock = system_clock, pid: int | None = None
    ) -> None:
        environment = os.environ if environment is None else environment
        self._clock = clock
        self._address = _address(environment.get("NOTIFY_SOCKET", ""))
        self._period_ns = _watchdog_ns(environment, os.getpid() if pid is None else pid) // 2
        self._status = ""
        self._status_ns: int | None = None
        self._kicked_ns: int | None = None
        self._said: Set[str] = set()
        self._socket: socket.socket | None = None
        if self._address:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
            self._socket.setblocking(False)

    def ready(self) -> None:
        """The start is over; sent once."""
        self._send_once("READY=1")

    def stopping(self) -> None:
        """The end has begun; sent once."""
        self._send_once("STOPPING=1")

    def status(self, text: str) -> None:
        """For `systemctl status`, one line; sent where it changed, and not at once again. What systemd does not take is
        sent again."""
        line, now_ns = "STATUS=" + " ".join(text.split()), self._clock()
        if line != self._status and (self._status_ns is None or now_ns - self._status_ns >= STATUS_NS):
            self._status_ns = now_ns
            if self._send(line):
                self._status = line

    def alive(self) -> None:
        """To be called in each cycle of the loop that must not hang; passed on twice in the watchdog's time."""
        now_ns = self._clock()
        if not self._period_ns or (self._kicked_ns is not None and now_ns - self._kicked_ns < self._period_ns):
            return
        self._kicked_ns = now_ns
        self._send("WATCHDOG=1")

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _send_once(self, line: str) -> None:
        if line not in self._said and self._send(line):
            self._said.add(line)

    def _send(self, line: str) -> bool:
        """Whether it was taken; where nobody is to be told, it was."""
        if self._socket is None:
            return True
        try:
            self._socket.sendto(line.encode(), self._address)
        except OSError as error:
            _LOG.warning("systemd does not take %s: %s", line, error)
            return False
        return True


def _address(name: str) -> str:
    if name and name[0] not in "/@":
        raise RefusedError(f"NOTIFY_SOCKET: expected a path or an abstract name, got {name!r}")
    return "\0" + name[1:] if name.startswith("@") else name


def _watchdog_ns(environment: Mapping[str, str], pid: int) -> int:
    """0: there is none, or it is another process'."""
    values = {}
    for name in ("WATCHDOG_USEC", "WATCHDOG_PID"):
        text = environment.get(name, "")
        if text and not (text.isdecimal() and int(text) > 0):
            raise RefusedError(f"{name}: expected a whole number above 0, got {text!r}")
        values[name] = int(text or 0)
    return values["WATCHDOG_USEC"] * 1000 if values["WATCHDOG_PID"] in (0, pid) else 0
