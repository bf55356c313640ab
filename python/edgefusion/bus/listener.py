# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a robot says, as a program reads it that has no more than a viewer's keys."""

from __future__ import annotations

from typing import Any, Callable, FrozenSet, Iterator, NamedTuple, Optional, Sequence, TypeVar

import zenoh

from edgefusion.bus import topics
from edgefusion.bus.healths import Healths
from edgefusion.bus.latest import Latest
from edgefusion.bus.liveliness import Alive
from edgefusion.bus.reader import Reader
from edgefusion.bus.session import UnreachableError
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.topics import Topic, key_of
from edgefusion.clock import Clock, system_clock
from edgefusion.messages.mission_report import MissionReport
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_battery import Battery, to_battery
from edgefusion.messages.to_detections_detail import Detections, to_detections_detail
from edgefusion.messages.to_healths import Report
from edgefusion.messages.to_mission import to_mission
from edgefusion.types import Detection

TURN_S = 0.2
"""So often a wait looks whether the session was closed."""

T = TypeVar("T")


class Status(NamedTuple):
    """What the robot has last said of itself; None, or empty, before it has. age_s: of mission, since it came here."""

    mission: Optional[MissionReport]
    age_s: Optional[float]
    healths: Sequence[Report]
    battery: Optional[Battery]
    alive: FrozenSet[str]


class Listener:
    """name: of the robot. What it gives to iterate over comes from the call on; who is too slow for it gets the newest.
    It ends when the session is closed, and raises UnreachableError when nothing comes for timeout_s. Malformed messages
    are left out.
    """

    def __init__(self, session: zenoh.Session, name: str, clock: Clock = system_clock) -> None:
        self.session, self.name, self._clock = session, name, clock
        self._alive = Alive(session, name)
        self._mission = Latest(session, name, topics.MISSION, to_mission, clock)
        self._healths = Healths(session, name, clock)
        self._battery = Latest(session, name, topics.BATTERY, lambda message: to_battery(message, Stamper()), clock)

    @property
    def status(self) -> Status:
        """Does not wait."""
        mission = self._mission.value
        healths = self._healths.reports
        return Status(mission, self._mission.age_s, healths, self._battery.value, self._alive.components)

    def detections(self, timeout_s: Optional[float] = None) -> Iterator[Detection]:
        """Each object in each frame, as the robot has seen it."""
        frames = self.frames(timeout_s)
        return (detection for frame in frames for detection in frame.detections)

    def frames(self, timeout_s: Optional[float] = None) -> Iterator[Detections]:
        """The objects of each frame together, also of one that has none."""
        return self.read(topics.DETECTIONS_DETAIL, to_detections_detail, timeout_s)

    def missions(self, timeout_s: Optional[float] = None) -> Iterator[MissionReport]:
        """How the mission is, on each change and a few times a second."""
        return self.read(topics.MISSION, to_mission, timeout_s)

    def read(
        self, topic: Topic, convert: Callable[[Any], T], timeout_s: Optional[float] = None, newest: int = 10
    ) -> Iterator[T]:
        """What any topic says. convert: makes of a message what is wanted of it."""
        subscriber = Subscriber(self.session, key_of(self.name, topic.name), newest, clock=self._clock)
        return self._each(subscriber, Reader(topic, convert), timeout_s)

    def _each(self, subscriber: Subscriber, reader: Reader[T], timeout_s: Optional[float]) -> Iterator[T]:
        try:
            while True:
                value = self._next(subscriber, reader, timeout_s)
                if value is None:
                    return
                yield value
        finally:
            if not self.session.is_closed():
                subscriber.undeclare()

    def _next(self, subscriber: Subscriber, reader: Reader[T], timeout_s: Optional[float]) -> Optional[T]:
        """None where the session was closed."""
        since_ns = self._clock()
        while not self.session.is_closed():
            received = subscriber.wait(TURN_S if timeout_s is None else min(TURN_S, timeout_s))
            value = None if received is None else reader.read(received.payload)
            if value is not None:
                return value
            if timeout_s is not None and self._clock() - since_ns >= timeout_s * 1e9:
                raise UnreachableError(f"{subscriber.key}: nothing came for {timeout_s:g} s: is the robot running?")
        return None
