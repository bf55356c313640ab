# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One user per port: a lock file that names who holds it.

The port's own lock (TIOCEXCL, flock) names nobody. This one is held by the kernel for as long as its process
lives, so that a killed one leaves nothing to clear away; the text in the file is only for people.
"""

from __future__ import annotations

import fcntl
import os
import tempfile
from pathlib import Path

from edgefusion.errors import RefusedError


class PortBusyError(RefusedError):
    """Somebody else holds the port; the message names them."""


class PortLock:
    """Holds the lock of a port from acquire() to release(). holder: the name that others are told."""

    def __init__(self, port: str, holder: str, folder: Path | None = None) -> None:
        self._folder = folder or Path(tempfile.gettempdir())
        self._port, self._holder = port, holder
        self.path = self._path()
        self._file: int | None = None

    def _path(self) -> Path:
        """Of the device that the name leads to now: one that was plugged in again may have another number."""
        name = self._port if "://" in self._port else os.path.realpath(self._port)
        return self._folder / f"edgefusion-{name.strip('/').replace('/', '_')}.lock"

    def acquire(self) -> None:
        """Raises PortBusyError at once where another holds it, RefusedError where the file cannot be written."""
        path = self._path()
        if self._file is not None and path == self.path:
            return
        self.release()
        self.path = path
        try:
            file = _open(self.path)
        except OSError as error:
            raise RefusedError(f"{self.path}: expected a lock file that can be written, got {error}") from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.pread(file, 200, 0).decode(errors="replace").strip() or "a process that is just starting"
            os.close(file)
            raise PortBusyError(f"{self._port}: expected a free port, it is held by {holder}") from None
        os.ftruncate(file, 0)
        os.pwrite(file, f"{self._holder} (pid {os.getpid()})\n".encode(), 0)
        self._file = file

    def release(self) -> None:
        """Lets others have the port. The file stays: whoever removed it could remove another's."""
        if self._file is not None:
            os.ftruncate(self._file, 0)
            os.close(self._file)
            self._file = None


def _open(path: Path) -> int:
    """Without O_CREAT first: Linux refuses it for another user's file in a folder like /tmp."""
    flags = os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW
    try:
        return os.open(path, flags)
    except FileNotFoundError:
        file = os.open(path, flags | os.O_CREAT, 0o666)
        os.fchmod(file, 0o666)
        return file
