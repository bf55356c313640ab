# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Clocks, passed in wherever time is needed: nanoseconds that never step back."""

from __future__ import annotations

import time
from typing import Callable

from edgefusion.errors import RefusedError

Clock = Callable[[], int]
"""Returns nanoseconds of a monotonic clock."""

system_clock: Clock = time.monotonic_ns


class SimClock:
    """A clock that stands until it is advanced: simulated time runs as fast as the machine can."""

    def __init__(self, start_ns: int = 0) -> None:
        self._now_ns = start_ns

    def __call__(self) -> int:
        return self._now_ns

    def advance(self, ns: int) -> int:
        """Moves the time on and returns it. Raises RefusedError for less than nothing."""
        if ns < 0:
            raise RefusedError(f"ns: expected at least 0, got {ns}: a clock never steps back")
        self._now_ns += ns
        return self._now_ns
