# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What one of the robot's processes takes from another, with its stamp, which must be of the clock it reckons with."""

from __future__ import annotations

import logging
from typing import Any, Callable, Generic, List, Optional, Tuple, TypeVar

import zenoh

from edgefusion.bus.subscriber import Received, Subscriber, nobody
from edgefusion.bus.tags import SampleTag, read_tag
from edgefusion.bus.topics import Topic, key_of
from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode

AHEAD_NS = 100_000_000
"""So much ahead a stamp may be: who is on another computer reads the robot's clock no more exactly than its network is.
"""

log = logging.getLogger(__name__)

T = TypeVar("T")


class Feed(Generic[T]):
    """clock_id: of the clock whose stamps are taken; None takes any, for who compares them with no clock of his own.
    convert: makes of a message what is wanted, or raises RefusedError. For one thread; `wake` is called in another.
    refused: how many there were of which nothing came; reason: of the newest of them, empty where all were taken.
    """

    def __init__(
        self,
        session: zenoh.Session,
        robot: str,
        topic: Topic,
        convert: Callable[[Any], T],
        clock_id: Optional[str],
        newest: int = 1,
        wake: Callable[[], None] = nobody,
        clock: Clock = system_clock,
    ) -> None:
        self._topic, self._convert, self._clock_id = topic, convert, clock_id
        self._subscriber = Subscriber(session, key_of(robot, topic.name), newest, wake, clock)
        self.refused, self.reason = 0, ""

    @property
    def waiting(self) -> int:
        """How many have come that nobody has looked at."""
        return self._subscriber.waiting

    def take(self) -> List[Tuple[SampleTag, T]]:
        """The newest of what came since the last time, the oldest of them first."""
        taken = []
        for received in self._subscriber.take():
            try:
                taken.append(self._accept(received))
            except RefusedError as error:
                self._note(str(error))
        return taken

    def undeclare(self) -> None:
        """Nothing comes any more."""
        self._subscriber.undeclare()

    def _accept(self, received: Received) -> Tuple[SampleTag, T]:
        if received.attachment is None:
            raise RefusedError("expected a stamp, got none")
        tag = read_tag(SampleTag, received.attachment)
        if self._clock_id is not None and tag.clock != self._clock_id:
            raise RefusedError(f"expected stamps of the clock {self._clock_id}, got one of {tag.clock}")
        early_ns = tag.stamp_ns - received.received_ns
        if self._clock_id is not None and early_ns > AHEAD_NS:  # it would not become old in time
            raise RefusedError(f"expected a stamp of before it came, got one of {early_ns / 1e9:.3f} s later")
        return tag, self._convert(decode(self._topic.message, received.payload))

    def _note(self, reason: str) -> None:
        self.refused, self.reason = self.refused + 1, reason
        if self.refused == 1:
            log.warning("%s: refused, and from now on only counted: %s", self._subscriber.key, reason)
