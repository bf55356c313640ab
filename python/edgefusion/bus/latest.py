# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What was last said on a topic, decoded when somebody asks."""

from __future__ import annotations

from typing import Any, Callable, Generic, Optional, TypeVar

import zenoh

from edgefusion.bus.reader import Reader
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.topics import Topic, key_of
from edgefusion.clock import Clock

T = TypeVar("T")


class Latest(Generic[T]):
    """convert: makes of a message what is wanted of it."""

    def __init__(
        self, session: zenoh.Session, robot: str, topic: Topic, convert: Callable[[Any], T], clock: Clock
    ) -> None:
        self._reader, self._clock = Reader(topic, convert), clock
        self._subscriber = Subscriber(session, key_of(robot, topic.name), clock=clock)
        self._value: Optional[T] = None
        self._received_ns: Optional[int] = None

    @property
    def value(self) -> Optional[T]:
        """None before there is one. Malformed messages are left out."""
        for received in self._subscriber.take():
            value = self._reader.read(received.payload)
            if value is not None:
                self._value, self._received_ns = value, received.received_ns
        return self._value

    @property
    def age_s(self) -> Optional[float]:
        """Of the value that was last given, since it came."""
        return None if self._received_ns is None else (self._clock() - self._received_ns) / 1e9
