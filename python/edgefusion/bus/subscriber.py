# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What came on a key, the newest few of it, each with the time at which it came."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Callable, Deque, Optional

import zenoh

from edgefusion.bus.callbacks import Guarded
from edgefusion.bus.session import Declared
from edgefusion.clock import Clock, system_clock
from edgefusion.waiting import Wake


@dataclass(frozen=True)
class Received:
    """received_ns: by this process's clock. encoding: as the sender says."""

    key: str
    payload: bytes
    attachment: Optional[bytes]
    encoding: str
    received_ns: int


def nobody() -> None:
    """Is woken."""


class Subscriber:
    """Keeps the newest of what comes until somebody takes it; `wake` is called, in a thread of Zenoh's, when it comes.

    received, dropped: how many there were, and of them how many were pushed out by newer ones.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        newest: int = 1,
        wake: Callable[[], None] = nobody,
        clock: Clock = system_clock,
    ) -> None:
        self.key, self._clock, self._wake = key, clock, wake
        self._ring: Deque[Received] = deque(maxlen=newest)
        self._lock = threading.Lock()
        self._waited: Optional[Wake] = None  # from the first wait on
        self.received = self.dropped = 0
        self._guarded: Guarded[zenoh.Sample] = Guarded(key, self._take_in)
        self._subscriber: Declared = session.declare_subscriber(key, self._guarded.handler)

    @property
    def failures(self) -> int:
        """How often a sample could not be taken in, or `wake` raised."""
        return self._guarded.failures

    @property
    def waiting(self) -> int:
        """How many are there."""
        return len(self._ring)

    def take(self) -> list[Received]:
        """All that is there, the oldest first; it is there no longer."""
        with self._lock:
            taken = list(self._ring)
            self._ring.clear()
        return taken

    def wait(self, timeout_s: float) -> Optional[Received]:
        """The oldest that is there, or the next that comes; None when none comes in time."""
        end_s = time.monotonic() + timeout_s
        while True:
            with self._lock:
                waited = self._waited = self._waited or Wake()
                if self._ring:
                    return self._ring.popleft()
            left_s = end_s - time.monotonic()
            if left_s <= 0:
                return None
            waited.wait(left_s)

    def undeclare(self) -> None:
        """Nothing comes any more."""
        self._subscriber.undeclare()
        with self._lock:
            self._waited = None  # its handles are few, and the garbage collector comes late

    def _take_in(self, sample: zenoh.Sample) -> None:
        received_ns = self._clock()
        if sample.kind != zenoh.SampleKind.PUT:
            return
        attachment = None if sample.attachment is None else sample.attachment.to_bytes()
        payload = sample.payload.to_bytes()
        received = Received(str(sample.key_expr), payload, attachment, str(sample.encoding), received_ns)
        with self._lock:
            self.received += 1
            self.dropped += len(self._ring) == self._ring.maxlen
            self._ring.append(received)
            if self._waited is not None:
                self._waited()
        self._wake()
