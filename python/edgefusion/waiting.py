# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Waits that a step of the wall clock does not change: those of threading go by it before Python 3.11."""

from __future__ import annotations

import os
import select
import threading
import time
from contextlib import suppress
from typing import Callable

from edgefusion.clock import Clock, system_clock

LOOK_S = 0.002


class Wake:
    """A wait that other threads can end early: on a pipe, whose timeouts go by the monotonic clock."""

    def __init__(self) -> None:
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        os.set_blocking(self._writer, False)

    def __call__(self) -> None:
        """Ends the wait that is under way, or else the next one. From any thread, never waits."""
        with suppress(BlockingIOError):
            os.write(self._writer, b"!")

    def wait(self, seconds: float) -> bool:
        """Whether it was ended early."""
        readable, _, _ = select.select([self._reader], [], [], max(0.0, seconds))
        if readable:
            os.read(self._reader, 4096)
        return bool(readable)

    def __del__(self) -> None:
        # Not before the last thread that may call it is gone: the number of a closed pipe is soon somebody else's.
        os.close(self._reader)
        os.close(self._writer)


def join(
    thread: threading.Thread, timeout_s: float, clock: Clock = system_clock, pause: Callable[[float], None] = time.sleep
) -> bool:
    """Whether the thread has ended by then, or was never started."""
    end_ns = clock() + round(timeout_s * 1e9)
    while thread.is_alive() and clock() < end_ns:
        pause(LOOK_S)
    return not thread.is_alive()
