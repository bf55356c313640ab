# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The newest pictures of a camera, for one thread that adds and others that look."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

from edgefusion.clock import Clock
from edgefusion.types import Frame


class NoFrameError(Exception):
    """There is no picture that may be used, and why."""


class Arrival(NamedTuple):
    """A picture and when it reached the computer, before anything was waited for."""

    arrival_ns: int
    frame: Frame


class FrameRing:
    """The pictures of the last keep_ns. Ages count from their arrivals: a stamp is earlier by the exposure."""

    def __init__(self, keep_ns: int, clock: Clock) -> None:
        self._keep_ns, self._clock = keep_ns, clock
        self._arrivals: deque[Arrival] = deque()
        self._lock = threading.Lock()

    def add(self, arrival: Arrival) -> None:
        """Adds the newest picture and forgets those that are too old beside it."""
        with self._lock:
            self._arrivals.append(arrival)
            while arrival.arrival_ns - self._arrivals[0].arrival_ns > self._keep_ns:
                self._arrivals.popleft()

    def clear(self) -> None:
        """Forgets all pictures."""
        with self._lock:
            self._arrivals.clear()

    def latest(self, max_age_ns: int) -> Frame:
        """The newest picture. Raises NoFrameError where there is none, or it is older, or from the future."""
        with self._lock:
            newest = self._arrivals[-1] if self._arrivals else None
        if newest is None:
            raise NoFrameError("no picture: none came yet")
        age_ns = self._clock() - newest.arrival_ns
        if not 0 <= age_ns <= max_age_ns:
            raise NoFrameError(
                f"age of the newest picture: expected 0 to {max_age_ns / 1e9:.3f} s, got {age_ns / 1e9:.3f} s"
            )
        return newest.frame

    def after(self, stamp_ns: int) -> list[Frame]:
        """The pictures with later stamps, in order."""
        with self._lock:
            return [arrival.frame for arrival in self._arrivals if arrival.frame.stamp_ns > stamp_ns]
