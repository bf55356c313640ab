# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""pyserial's ports with a deadline on everything that it would wait for."""

from __future__ import annotations

import errno
import termios
import time
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

import serial

from edgefusion.errors import RefusedError

READ_S = 0.02
WRITE_S = 0.1
_SOCKET = "socket://"
_HELD = (errno.EAGAIN, errno.EBUSY)
FAILURES = (serial.SerialException, OSError, termios.error)


def open_port(name: str, baudrate: int) -> Any:
    """8N1. Raises what pyserial raises, RefusedError for a name or speed that says nothing."""
    if name.startswith(_SOCKET) and not _is_address(name):
        raise RefusedError(f"{name}: expected {_SOCKET}HOST:PORT")
    try:
        return serial.serial_for_url(name, baudrate, timeout=READ_S, write_timeout=WRITE_S, exclusive=True)
    except ValueError as error:
        raise RefusedError(f"{name}: expected a port and a speed that it has, got {baudrate}: {error}") from error


def _is_address(name: str) -> bool:
    try:
        parts = urlsplit(name)
        return bool(parts.hostname and parts.port)
    except ValueError:  # no number, or one that no port has
        return False


def reason(error: Exception) -> str:
    """Why a port was not opened: pyserial's words repeat its name."""
    inner = error.__context__ or error
    if getattr(inner, "errno", None) in _HELD:
        return "another program holds it"
    return str(inner.args[1]) if len(inner.args) > 1 else str(error)


def drain(port: Any) -> None:
    """Waits for the last byte to leave, which tcdrain would do for ever. A socket does not tell."""
    deadline_s = time.monotonic() + WRITE_S
    while getattr(port, "out_waiting", 0) and time.monotonic() < deadline_s:
        time.sleep(0.001)


def close_port(port: Any) -> None:
    """Raises nothing. Bytes that nobody takes are forgotten: they would hold up the closing for 30 s."""
    with suppress(*FAILURES):
        if getattr(port, "out_waiting", 0):  # a pty's are on their way already, and would be lost
            port.reset_output_buffer()
    with suppress(*FAILURES):
        port.close()
