# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated device's serial port: a pseudo-terminal, whose other end knows at which speed a client opened it."""

from __future__ import annotations

import os
import select
import termios
import tty
from contextlib import suppress
from pathlib import Path

from edgefusion.errors import RefusedError

_READ_BYTES = 4096
_SPEEDS = {
    getattr(termios, f"B{baudrate}"): baudrate
    for baudrate in (9600, 19200, 38400, 57600, 115200, 500000)
    if hasattr(termios, f"B{baudrate}")
}


class PtyWire:
    """name: what a client opens. link: a path that leads there, made and removed.

    Raises RefusedError where something else is at that path.
    """

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        self.name = os.ttyname(slave)
        os.close(slave)  # only clients hold it, so that it can be told whether there is one
        self._hung_up = select.poll()
        self._hung_up.register(self._master, 0)
        if link is not None:
            _make_link(link, self.name)
            self.name = str(link)

    @property
    def baudrate(self) -> int | None:
        """The client's speed as it is now: a pty does not tell at which one its bytes were
        written. 0: one that no device has."""
        with suppress(termios.error):
            return _SPEEDS.get(termios.tcgetattr(self._master)[4], 0)  # a master's settings are those of its other end
        return None

    @property
    def has_client(self) -> bool:
        """Whether somebody has it open."""
        return not self._hung_up.poll(0)

    def read(self) -> bytes:
        """What the client wrote; never waits."""
        with suppress(OSError):  # EAGAIN, or EIO while nobody has it open
            return os.read(self._master, _READ_BYTES)
        return b""

    def write(self, data: bytes) -> None:
        """What nobody takes is lost, as on a line: who opens it later hears nothing of before."""
        if self.has_client:
            with suppress(OSError):
                os.write(self._master, data)

    def close(self) -> None:
        """As if it were unplugged."""
        if self._link is not None:
            with suppress(OSError):
                self._link.unlink()
        with suppress(OSError):
            os.close(self._master)
        self._master = -1  # its number may soon be another file's


def _make_link(link: Path, target: str) -> None:
    try:
        link.parent.mkdir(parents=True, exist_ok=True)
        if link.is_symlink():  # left by one that was killed
            link.unlink()
        link.symlink_to(target)
    except OSError as error:
        raise RefusedError(f"{link}: expected a place for a link, got {error.strerror}") from error
