# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When to say again what only sometimes changes."""

from __future__ import annotations

from typing import Hashable


class OnChange:
    """At once when it changes, and else so often that who comes later knows it soon. Pure: the time is passed in."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._said: Hashable = None
        self._said_ns: int | None = None

    def due(self, now_ns: int, what: Hashable) -> bool:
        """Whether to say it now; if so it counts as said."""
        if self._said_ns is not None and what == self._said and now_ns - self._said_ns < self._period_ns:
            return False
        self._said, self._said_ns = what, now_ns
        return True
