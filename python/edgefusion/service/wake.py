# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A wait that other threads can end early."""

from __future__ import annotations

import os
import select
from contextlib import suppress


class Wake:
    """A pipe: its timeouts go by the monotonic clock, those of threading by the wall clock before Python 3.11."""

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
