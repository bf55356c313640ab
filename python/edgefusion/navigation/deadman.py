# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A deadman switch: it must be fed with fresh stamps, and once it was not, it wants several before it trusts again."""

from __future__ import annotations

from enum import Enum

from edgefusion.errors import RefusedError


class DeadmanState(str, Enum):
    """Of a deadman switch: whether what it watches may be relied on."""

    NEEDS_FEED = "needs feed"
    ARMED = "armed"


class Deadman:
    """Watches the stamp of the newest of what something sends. It reads no clock, and grants no time for free.

    | state      | a later stamp, fresh                      | the newest is not fresh, or restart |
    |------------|-------------------------------------------|-------------------------------------|
    | NEEDS_FEED | counts; ARMED at the `needed`-th in a row | counts from 0                       |
    | ARMED      | ARMED                                     | NEEDS_FEED, from 0                  |

    Fresh: at most max_age_ns old, and not of the future, since a stamp of the future would stay fresh for too long.
    A stamp that was seen before feeds nothing, however fresh.
    """

    def __init__(self, name: str, max_age_ns: int, needed: int = 1) -> None:
        if max_age_ns <= 0 or needed <= 0:
            raise RefusedError(f"{name}: expected a positive age limit and count, got {max_age_ns} ns and {needed}")
        self._name, self._max_age_ns, self._needed = name, max_age_ns, needed
        self._latest_ns: int | None = None
        self._fed = 0

    @property
    def state(self) -> DeadmanState:
        return DeadmanState.ARMED if self._fed >= self._needed else DeadmanState.NEEDS_FEED

    def restart(self) -> None:
        """Trusts nothing that it was fed until now."""
        self._fed = 0

    def step(self, now_ns: int, stamp_ns: int | None) -> str:
        """Looks at the newest stamp, None where there is none yet; says what is wrong, and nothing while ARMED.

        The words stay the same for as long as the fault does.
        """
        fault = self._fault(now_ns, stamp_ns)
        if fault:
            self.restart()
            return fault
        assert stamp_ns is not None
        if self._latest_ns is None or stamp_ns > self._latest_ns:
            self._latest_ns = stamp_ns
            self._fed = min(self._fed + 1, self._needed)
        if self.state is DeadmanState.ARMED:
            return ""
        return f"{self._name}: waiting for {'a new one' if self._needed == 1 else f'{self._needed} fresh in a row'}"

    def _fault(self, now_ns: int, stamp_ns: int | None) -> str:
        """Why the newest is not fresh, if it is not."""
        if stamp_ns is None:
            return f"{self._name}: none yet"
        if stamp_ns > now_ns:
            return f"{self._name}: stamp of the future"
        if now_ns - stamp_ns > self._max_age_ns:
            return f"{self._name}: older than {self._max_age_ns / 1e9:g} s"
        return ""
