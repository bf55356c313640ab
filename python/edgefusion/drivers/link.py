# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Bytes to and from a device on a serial port, a pty or `socket://host:port`. Nothing in here waits for long.

A read takes 20 ms at most, a write 100 ms; of a socket, pyserial takes up to 5 s to connect and 0.3 s to close.
Errors tell what is wrong with the line, and leave the port closed; when to open it again is its user's choice.
"""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path
from typing import Any

import serial

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.port import FAILURES, WRITE_S, close_port, drain, open_port, reason
from edgefusion.drivers.port_lock import PortLock
from edgefusion.errors import RefusedError


class LinkError(Exception):
    """Something is wrong with the line, in one line that names the port."""


class LinkLostError(LinkError):
    """The port is not there, or vanished."""


class LinkSilentError(LinkError):
    """The port is there, but for longer than allowed nothing came."""


class LinkBlockedError(LinkError):
    """The other end does not take what is written."""


class Link:
    """One device's line. name: the port. holder: what a second user of the port is told."""

    def __init__(
        self,
        name: str,
        baudrate: int,
        holder: str = "edgefusion",
        clock: Clock = system_clock,
        lock_folder: Path | None = None,
    ) -> None:
        self.name = name
        self._baudrate = baudrate
        self._clock = clock
        self._lock = PortLock(name, holder, lock_folder)
        self._port: Any = None
        self._silence_limit_s = math.inf
        self._heard_ns = 0

    @property
    def is_open(self) -> bool:
        return self._port is not None

    @property
    def baudrate(self) -> int:
        return self._baudrate

    def open(self) -> None:
        """Raises LinkLostError where there is no such device, PortBusyError where another instance holds it."""
        if self._port is not None:
            return
        self._lock.acquire()
        try:
            self._port = open_port(self.name, self._baudrate)
        except FAILURES as error:
            raise LinkLostError(f"{self.name}: cannot be opened: {reason(error)}") from error
        self.expect_within(math.inf)

    def expect_within(self, silence_limit_s: float) -> None:
        """From now on a pause of more than this raises LinkSilentError; math.inf: none does, as after opening."""
        self._silence_limit_s = silence_limit_s
        self._heard_ns = self._clock()

    def read(self, n: int) -> bytes:
        """n bytes, or what came of them within 20 ms: perhaps none. Raises LinkLostError, LinkSilentError.

        A process that was halted finds bytes waiting: that is no silence.
        """
        try:
            data = bytes(self._opened().read(n))
        except FAILURES as error:
            raise self._lost(error) from error
        now_ns = self._clock()
        if data:
            self._heard_ns = now_ns
        elif now_ns - self._heard_ns > self._silence_limit_s * 1e9 and not self.waiting_bytes:
            self._drop()
            raise LinkSilentError(f"{self.name}: nothing came for {(now_ns - self._heard_ns) / 1e9:.2f} s")
        return data

    @property
    def waiting_bytes(self) -> int:
        """How many have arrived and were not read. Raises LinkLostError."""
        try:
            return int(self._opened().in_waiting)
        except FAILURES as error:
            raise self._lost(error) from error

    def write(self, data: bytes) -> None:
        """Hands all of it to the port within 100 ms. Raises LinkLostError, LinkBlockedError."""
        try:
            self._opened().write(data)
        except serial.SerialTimeoutException as error:
            self._drop()
            raise LinkBlockedError(f"{self.name}: took no bytes for {WRITE_S} s") from error
        except FAILURES as error:
            raise self._lost(error) from error

    def discard_input(self) -> None:
        """Forgets what has arrived and was not read. Raises LinkLostError."""
        try:
            self._opened().reset_input_buffer()
        except FAILURES as error:
            raise self._lost(error) from error

    def set_baudrate(self, baudrate: int) -> None:
        """After what was written has left; reopening keeps it. Raises RefusedError for a speed the port has not."""
        try:
            drain(self._opened())
            self._port.baudrate = baudrate
        except ValueError as error:
            raise RefusedError(f"{self.name}: expected a speed that the port has, got {baudrate}: {error}") from error
        except FAILURES as error:
            raise self._lost(error) from error
        self._baudrate = baudrate

    def close(self) -> None:
        """Lets what was written leave, for 100 ms at most, and gives the port to others. Raises nothing."""
        if self._port is not None:
            with suppress(*FAILURES):
                drain(self._port)
        self._drop()
        self._lock.release()

    def _opened(self) -> Any:
        if self._port is None:
            raise LinkLostError(f"{self.name}: is not open")
        return self._port

    def _lost(self, error: Exception) -> LinkLostError:
        self._drop()
        return LinkLostError(f"{self.name}: vanished: {error}")

    def _drop(self) -> None:
        """Closes the port and keeps the lock: nobody shall take a device that is about to come back."""
        port, self._port = self._port, None
        if port is not None:
            close_port(port)
