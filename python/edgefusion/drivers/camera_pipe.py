# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A child process whose output is read with deadlines, and which is killed where it hangs.

OpenCV's read() can hang for ever, no thread that hangs can be ended, and releasing the capture beside it crashes the
process: so whatever may hang has a process of its own, which costs one copy of a picture through a pipe.
"""

from __future__ import annotations

import fcntl
import os
import selectors
import signal
import subprocess
import sys
from contextlib import suppress
from typing import IO, Sequence

NOTES_BYTES = 2000
PIPE_BYTES = 1 << 20
"""What Linux allows everyone: a VGA picture then takes one turn of the reading thread, not fifteen."""
F_SETPIPE_SZ = 1031
KILL_S = 1.0


class PipeEndedError(Exception):
    """The child gives no more, and its last words."""


class ChildPipe:
    """A child that gets `request` on its standard input, which stays open as long as its parent lives.

    Raises PipeEndedError where the program cannot be started.
    """

    def __init__(self, command: Sequence[str], request: bytes = b"") -> None:
        try:
            self._child = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                bufsize=0,
                start_new_session=True,
            )
        except OSError as error:
            raise PipeEndedError(f"{command[0]}: {error.strerror}") from error
        assert self._child.stdin is not None and self._child.stdout is not None and self._child.stderr is not None
        self._stdin, self._stdout, self._stderr = self._child.stdin, self._child.stdout, self._child.stderr
        self._notes, self._filled = b"", 0
        self._selector = selectors.DefaultSelector()
        for pipe in (self._stdout, self._stderr):
            os.set_blocking(pipe.fileno(), False)
            self._selector.register(pipe, selectors.EVENT_READ)
        if sys.platform == "linux":
            with suppress(OSError):  # refused where too many pipes are that large already: slower, but right
                fcntl.fcntl(self._stdout, F_SETPIPE_SZ, PIPE_BYTES)
        with suppress(BrokenPipeError):  # it has ended already: reading will tell
            self._stdin.write(request)

    @property
    def pid(self) -> int:
        """The child's process id."""
        return self._child.pid

    def fill(self, target: memoryview, timeout_s: float) -> bool:
        """Reads what comes within the time into a target; True once it is full.

        The same target must be given until then. Raises PipeEndedError at the end of the output.
        """
        ready = [key.fileobj for key, _ in self._selector.select(timeout_s)]
        if self._stderr in ready and not self._take_notes():
            self._selector.unregister(self._stderr)
        if self._stdout in ready:
            self._read_into(target)
        if self._filled < len(target):
            return False
        self._filled = 0
        return True

    def _read_into(self, target: memoryview) -> None:
        while self._filled < len(target):
            try:
                count = os.readv(self._stdout.fileno(), [target[self._filled :]])
            except BlockingIOError:
                return
            if count == 0:
                raise PipeEndedError(self._last_words())
            self._filled += count

    def _take_notes(self) -> bool:
        """Reads what it wrote to its standard error; False where that was nothing."""
        try:
            notes = os.read(self._stderr.fileno(), NOTES_BYTES)
        except BlockingIOError:
            return False
        self._notes = (self._notes + notes)[-NOTES_BYTES:]
        return bool(notes)

    def _last_words(self) -> str:
        while self._take_notes():  # what it wrote before it ended is here, though perhaps not read
            pass
        lines = self._notes.decode("utf-8", "replace").strip().splitlines()
        return lines[-1].strip() if lines else "it ended and said nothing"

    def close(self) -> None:
        """Kills the child, and all that it started, and waits a second for its end: the kernel may hold it longer."""
        if self._child.returncode is None:
            os.killpg(self._child.pid, signal.SIGKILL)
            with suppress(subprocess.TimeoutExpired):
                self._child.wait(KILL_S)
        self._selector.close()
        for pipe in (self._stdin, self._stdout, self._stderr):
            _close(pipe)


def _close(pipe: IO[bytes]) -> None:
    with suppress(BrokenPipeError):
        pipe.close()
