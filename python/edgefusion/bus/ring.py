# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What came on a key, the newest few of it, kept by Zenoh itself: however fast it comes, no Python runs for it."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import Any, Deque, Iterator

import zenoh
from zenoh.handlers import RingChannel

from edgefusion.bus.subscriber import Received
from edgefusion.clock import Clock, system_clock


class Ring:
    """For one thread, which looks often: what it finds counts as received when it looked before, which is no later than
    it came. So what came while that thread was held up is not taken for fresh.
    """

    def __init__(self, session: zenoh.Session, key: str, newest: int, clock: Clock = system_clock) -> None:
        self.key, self._clock = key, clock
        self._found: Deque[Received] = deque(maxlen=newest)
        self._looked_ns = clock()
        self._subscriber: Any = session.declare_subscriber(key, RingChannel(newest))

    @property
    def waiting(self) -> int:
        """How many are there."""
        self._look()
        return len(self._found)

    def take(self) -> list[Received]:
        """All that is there, the oldest first; it is there no longer."""
        self._look()
        taken = list(self._found)
        self._found.clear()
        return taken

    def undeclare(self) -> None:
        """Nothing comes any more."""
        self._subscriber.undeclare()

    def _look(self) -> None:
        looked_ns, self._looked_ns = self._looked_ns, self._clock()
        self._found.extend(_received(sample, looked_ns) for sample in self._samples())

    def _samples(self) -> Iterator[zenoh.Sample]:
        with suppress(zenoh.ZError):  # of a session that was closed nothing comes
            for _ in range(self._found.maxlen or 0):  # not for as long as a flood lasts
                sample = self._subscriber.try_recv()
                if sample is None:
                    return
                if sample.kind == zenoh.SampleKind.PUT:
                    yield sample


def _received(sample: zenoh.Sample, received_ns: int) -> Received:
    attachment = None if sample.attachment is None else sample.attachment.to_bytes()
    return Received(str(sample.key_expr), sample.payload.to_bytes(), attachment, str(sample.encoding), received_ns)
