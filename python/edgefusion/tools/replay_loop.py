# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A recording onto a bus, at any speed."""

from __future__ import annotations

import time
from typing import Callable, Iterable, Mapping, Optional

import zenoh

from edgefusion.bus.publisher import Publisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import TF_STATIC, Topic
from edgefusion.clock import Clock, system_clock
from edgefusion.messages.cdr import encode
from edgefusion.tools.replay_samples import Sample
from edgefusion.tools.replay_static import Standing

WAIT_S = 0.02

Sleep = Callable[[float], None]


class Pace:
    """speed: how many times faster than it was recorded; infinite: as fast as it can."""

    def __init__(self, speed: float, clock: Clock = system_clock, sleep: Sleep = time.sleep) -> None:
        self._speed, self._clock, self._sleep = speed, clock, sleep
        self._first_ns: Optional[int] = None
        self._began_ns = 0

    def wait(self, at_ns: int) -> None:
        """Until it is time for what is of then; the first is at once. Late it does not wait, and catches up."""
        if self._first_ns is None:
            self._first_ns, self._began_ns = at_ns, self._clock()
        due_ns = self._began_ns + round((at_ns - self._first_ns) / self._speed)
        left_ns = due_ns - self._clock()
        if left_ns > 0:
            self._sleep(left_ns / 1e9)


class Stage:
    """Where samples are put. clock_id: whose their stamps are."""

    def __init__(
        self, session: zenoh.Session, robot: str, topics: Iterable[Topic], clock_id: str, clock: Clock = system_clock
    ) -> None:
        tagger = Tagger()
        self._clock = clock
        self._publishers: Mapping[str, Publisher] = {
            topic.name: Publisher(session, robot, topic, tagger, clock_id) for topic in topics
        }
        self._standing = Standing()

    def wait_for_listeners(self, sleep: Sleep = time.sleep) -> None:
        """Until somebody listens to one of the topics."""
        while not any(publisher.wanted(self._clock()) for publisher in self._publishers.values()):
            sleep(WAIT_S)

    def put(self, sample: Sample) -> None:
        """Puts a sample, and what never moves again where it is time for it."""
        self._publishers[sample.topic.name].put_bytes(sample.payload, sample.stamp_ns)
        now_ns = self._clock()
        if sample.topic is TF_STATIC:
            self._standing.heard(sample.payload, sample.stamp_ns, now_ns)
        again = self._standing.due(now_ns)
        if again is not None:
            self._publishers[TF_STATIC.name].put_bytes(encode(again), self._standing.newest_ns)
