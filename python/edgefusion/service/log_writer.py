# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Writes log lines from a thread: who logs never waits for whoever reads, as a terminal that was halted by Ctrl-S."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections import deque
from contextlib import suppress
from typing import Callable, Deque, Sequence, TextIO

from edgefusion.clock import Clock, system_clock
from edgefusion.waiting import Wake

KEPT = 1000
"""So many lines wait for a reader that is slow; further ones are lost, and counted."""

FLUSH_NS = 300_000_000
"""So long the end of the program waits for what is not written yet."""

LATE_S = 1.0

_TURN_S = 0.005


class LogWriter(logging.Handler):
    """stream: written to beside its buffer where it is a file: what blocks there holds no lock that others need.

    late: asked now and then for what is to be told though nobody says it just now.
    """

    def __init__(
        self,
        stream: TextIO,
        late: Callable[[], Sequence[logging.LogRecord]] = tuple,
        clock: Clock = system_clock,
        pause: Callable[[float], None] = time.sleep,
    ) -> None:
        super().__init__()
        self._write, self._late = _writer_to(stream), late
        self._clock, self._pause = clock, pause
        self._lines: Deque[str] = deque()
        self._handed = self._written = self._lost = 0
        self._wake, self._closing = Wake(), False
        threading.Thread(target=self._run, name="log", daemon=True).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Returns at once."""
        if self._handed - self._written >= KEPT:
            self._lost += 1
            return
        line = self.format(record)
        if self._lost:
            line, self._lost = f"{line} ({self._lost} lines before it are lost: nobody read them)", 0
        self._lines.append(line)
        self._handed += 1  # after it: a signal's exception may come in between
        self._wake()

    def flush(self) -> None:
        """Waits until all is written, or FLUSH_NS. The end of the program calls it."""
        end_ns = self._clock() + FLUSH_NS
        while self._written < self._handed and self._clock() < end_ns:
            self._pause(_TURN_S)

    def close(self) -> None:
        """What was handed over is still written, if somebody reads."""
        self._closing = True
        self._wake()
        super().close()

    def _run(self) -> None:
        while not (self._closing and not self._lines):
            self._wake.wait(LATE_S)
            while self._lines:
                with suppress(OSError, ValueError):  # whoever read is gone: there is nobody to be told
                    self._write(f"{self._lines.popleft()}\n")
                self._written += 1
            self._tell_late()

    def _tell_late(self) -> None:
        # Not now if somebody has the lock: the program's end holds it while it waits for this thread to write.
        if self.lock is None or not self.lock.acquire(blocking=False):
            return
        try:
            for record in self._late():
                self.emit(record)
        finally:
            self.release()


def _writer_to(stream: TextIO) -> Callable[[str], object]:
    try:
        file = stream.fileno()
    except (OSError, ValueError):  # no file at all
        return stream.write
    return lambda text: _write_all(file, text.encode("utf-8", "backslashreplace"))


def _write_all(file: int, data: bytes) -> None:
    while data:
        data = data[os.write(file, data) :]
