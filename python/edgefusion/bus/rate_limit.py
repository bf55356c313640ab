# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""So many in a second, and so many at once: a token bucket. Pure: the time is passed in."""

from __future__ import annotations


class RateLimit:
    """max_hz: in the long run; burst: at once, after a pause."""

    def __init__(self, max_hz: float, burst: int) -> None:
        self._per_ns, self._burst = max_hz / 1e9, burst
        self._tokens = float(burst)
        self._last_ns: int | None = None

    def allows(self, now_ns: int) -> bool:
        """Whether one more may come now; if so it counts."""
        if self._last_ns is not None:
            self._tokens = min(self._burst, self._tokens + max(0, now_ns - self._last_ns) * self._per_ns)
        self._last_ns = now_ns if self._last_ns is None else max(now_ns, self._last_ns)
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True

    def give_back(self) -> None:
        """What was allowed last did not count after all."""
        self._tokens = min(self._burst, self._tokens + 1)
