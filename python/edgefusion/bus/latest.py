# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What was last said on a topic, decoded when somebody asks."""

from __future__ import annotations

from typing import Any, Callable, Generic, Optional, TypeVar

import zenoh

from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.topics import Topic, key_of
from edgefusion.clock import Clock
from edgefusion.messages.cdr import decode

T = TypeVar("T")


class Latest(Generic[T]):
    """convert: makes of a message what is wanted of it."""

    def __init__(
        self, session: zenoh.Session, robot: str, topic: Topic, convert: Callable[[Any], T], clock: Clock
    ) -> None:
        self._topic, self._convert, self._clock = topic, convert, clock
        self._subscriber = Subscriber(session, key_of(robot, topic.name), clock=clock)
        self._value: Optional[T] = None
        self._received_ns: Optional[int] = None

    @property
    def value(self) -> Optional[T]:
        """None before there is one. Raises WireError for a message that is none."""
        for received in self._subscriber.take():
            self._value = self._convert(decode(self._topic.message, received.payload))
            self._received_ns = received.received_ns
        return self._value

    @property
    def age_s(self) -> Optional[float]:
        """Of the value that was last given, since it came."""
        return None if self._received_ns is None else (self._clock() - self._received_ns) / 1e9
