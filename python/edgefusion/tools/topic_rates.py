# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How often something comes on each topic of a robot, and how much."""

from __future__ import annotations

import time
from typing import NamedTuple, Sequence

import zenoh

from edgefusion.bus.subscriber import Received, Subscriber
from edgefusion.bus.topics import TOPICS, Topic, key_of
from edgefusion.messages import ros_name

TURN_S = 0.05
_NEWEST = 1000


class Heard(NamedTuple):
    """Of one topic. type: as its messages say, or as it should be. rate_hz: 0 of fewer than two messages."""

    topic: str
    type: str
    direction: str
    messages: int
    rate_hz: float
    bytes_per_s: float


def listen(session: zenoh.Session, robot: str, seconds: float) -> list[Heard]:
    """Listens to all topics of this robot for so long."""
    taps = [_Tap(session, robot, topic) for topic in TOPICS.values()]
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        time.sleep(min(TURN_S, max(0.0, end_s - time.monotonic())))
        for tap in taps:
            tap.count()
    return [tap.heard(seconds) for tap in taps]


def in_words(heard: Sequence[Heard]) -> list[str]:
    """A table: what goes out from the robot, then what comes in to it."""
    row = "{:<21} {:<34} {:>6} {:>9}"
    lines = [row.format("topic", "type", "Hz", "kB/s")]
    for direction in ("out", "in"):
        for each in (one for one in heard if one.direction == direction):
            rate = f"{each.rate_hz:.1f}" if each.rate_hz else ("once" if each.messages else "-")
            size = f"{each.bytes_per_s / 1e3:.1f}" if each.messages else "-"
            lines.append(row.format(("> " if direction == "in" else "") + each.topic, each.type, rate, size))
    return [*lines, "> is told to the robot"]


class _Tap:
    def __init__(self, session: zenoh.Session, robot: str, topic: Topic) -> None:
        self._topic = topic
        self._subscriber = Subscriber(session, key_of(robot, topic.name), _NEWEST)
        self._first: Received | None = None
        self._last: Received | None = None
        self._bytes = 0

    def count(self) -> None:
        for received in self._subscriber.take():
            self._first, self._last = self._first or received, received
            self._bytes += len(received.payload)

    def heard(self, seconds: float) -> Heard:
        topic, messages = self._topic, self._subscriber.received
        return Heard(
            topic.name, self._type(), topic.direction.value, messages, self._rate_hz(messages), self._bytes / seconds
        )

    def _type(self) -> str:
        said = "" if self._last is None else self._last.encoding.partition(";")[2]
        return said or ros_name(self._topic.message)

    def _rate_hz(self, messages: int) -> float:
        if self._first is None or self._last is None:
            return 0.0
        span_ns = self._last.received_ns - self._first.received_ns
        return (messages - 1) * 1e9 / span_ns if span_ns else 0.0
