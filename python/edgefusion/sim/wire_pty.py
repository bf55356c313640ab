# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated device's serial port: a pseudo-terminal, whose other end knows at which speed a client opened it."""

from __future__ import annotations

import os
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
        self._master, self._slave = os.openpty()  # the slave stays open: clients come and go
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.name = os.ttyname(self._slave)
        if link is not None:
            _make_link(link, self.name)
            self.name = str(link)

    @property
    def baudrate(self) -> int | None:
        """The client's speed."""
        return _SPEEDS.get(termios.tcgetattr(self._slave)[4])

    def read(self) -> bytes:
        """What the client wrote; never waits."""
        with suppress(BlockingIOError):
            return os.read(self._master, _READ_BYTES)
        return b""

    def write(self, data: bytes) -> None:
        """What nobody takes is lost, as on a line."""
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def fileno(self) -> int:
        """To wait on."""
        return self._master

    def close(self) -> None:
        """As if it were unplugged."""
        if self._link is not None:
            with suppress(OSError):
                self._link.unlink()
        for descriptor in (self._master, self._slave):
            with suppress(OSError):
                os.close(descriptor)


def _make_link(link: Path, target: str) -> None:
    try:
        link.parent.mkdir(parents=True, exist_ok=True)
        if link.is_symlink():  # left by one that was killed
            link.unlink()
        link.symlink_to(target)
    except OSError as error:
        raise RefusedError(f"{link}: expected a place for a link, got {error.strerror}") from error
