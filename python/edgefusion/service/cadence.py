# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A steady pace, and how well it is kept."""

from __future__ import annotations

from collections import deque
from typing import Callable, Deque, NamedTuple

import numpy as np

from edgefusion.clock import Clock
from edgefusion.errors import RefusedError

_KEPT = 1200


class Lateness(NamedTuple):
    """By how much cycles began too late [ms]: of the last 1200, and the worst of all. cycles: how many there were."""

    cycles: int
    p50_ms: float
    p99_ms: float
    max_ms: float


class Cadence:
    """Cycles are due every period_ns from the first on. One that is missed is not made up for.

    wait(seconds): waits so long, or less where something shall be seen to at once.
    """

    def __init__(self, period_ns: int, clock: Clock, wait: Callable[[float], object]) -> None:
        if period_ns < 1:
            raise RefusedError(f"period_ns: expected at least 1, got {period_ns}")
        self._period_ns, self._clock, self._wait = period_ns, clock, wait
        self._due_ns: int | None = None
        self._late_ns: Deque[int] = deque(maxlen=_KEPT)
        self._cycles, self._latest_ns = 0, 0

    def next(self) -> int:
        """Waits for the next cycle, and returns the time; earlier where the wait was ended early: the next cycle is
        due when it was."""
        now_ns = self._clock()
        due_ns = now_ns if self._due_ns is None else self._due_ns
        if now_ns < due_ns:
            self._wait((due_ns - now_ns) / 1e9)
            now_ns = self._clock()
        if now_ns >= due_ns:
            self._began(now_ns - due_ns)
            due_ns += self._period_ns * ((now_ns - due_ns) // self._period_ns + 1)
        self._due_ns = due_ns
        return now_ns

    @property
    def lateness(self) -> Lateness:
        """So far."""
        if not self._cycles:
            return Lateness(0, 0.0, 0.0, 0.0)
        p50_ns, p99_ns = np.percentile(list(self._late_ns), (50, 99))
        return Lateness(self._cycles, float(p50_ns) / 1e6, float(p99_ns) / 1e6, self._latest_ns / 1e6)

    def _began(self, late_ns: int) -> None:
        self._cycles += 1
        self._late_ns.append(late_ns)
        self._latest_ns = max(self._latest_ns, late_ns)
