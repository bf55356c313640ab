# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When to try again what has failed: soon at first, then ever more seldom."""

from __future__ import annotations

FIRST_NS = 50_000_000
LONGEST_NS = 1_000_000_000


class Backoff:
    """Waits twice as long after every failure, 50 ms to 1 s by default. Time is passed in, nothing sleeps."""

    def __init__(self, first_ns: int = FIRST_NS, longest_ns: int = LONGEST_NS) -> None:
        self._first_ns = first_ns
        self._longest_ns = longest_ns
        self.reset()

    def reset(self) -> None:
        """All is well: the next try may come at once, and the next failure counts as the first."""
        self._wait_ns = self._first_ns
        self._due_ns: int | None = None

    def failed(self, now_ns: int) -> None:
        """Puts the next try off."""
        self._due_ns = now_ns + self._wait_ns
        self._wait_ns = min(2 * self._wait_ns, self._longest_ns)

    def due(self, now_ns: int) -> bool:
        """Whether it is time to try."""
        return self._due_ns is None or now_ns >= self._due_ns
