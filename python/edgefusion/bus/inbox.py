# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Commands of one kind, as the robot takes them: those that count, decoded; the others counted by why they do not."""

from __future__ import annotations

import logging
from typing import Any, Callable, Generic, Set, Tuple, TypeVar, Union

import zenoh

from edgefusion.bus.freshness import Freshness
from edgefusion.bus.ring import Ring
from edgefusion.bus.subscriber import Received, Subscriber
from edgefusion.bus.tags import session_of
from edgefusion.bus.topics import Topic, key_of
from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode

log = logging.getLogger(__name__)

T = TypeVar("T")

NEWEST = 8
"""So many wait between two steps of the loop: fewer than may come at once (`CommandLimits.burst`), so that of more than
those the last one counts, which is worth most."""

MOST_LOGGED = 64
"""So many senders' refusals are logged, each once; all are counted."""


class Inbox(Generic[T]):
    """convert: makes of a message what the robot works with, or raises RefusedError where it is no command.

    For one thread, which looks once in a cycle. to_the_moment: they count from when they came, by a callback for each,
    instead of from the look before (`ring.py`), which is cheaper where they flood, and takes a late thread's for old.
    """

    def __init__(
        self,
        session: zenoh.Session,
        robot: str,
        topic: Topic,
        convert: Callable[[Any], T],
        freshness: Freshness,
        clock: Clock = system_clock,
        to_the_moment: bool = False,
    ) -> None:
        self._topic, self._convert, self.freshness = topic, convert, freshness
        self._logged: Set[str] = set()
        key = key_of(robot, topic.name)
        self._came: Union[Ring, Subscriber] = (
            Subscriber(session, key, NEWEST, clock=clock) if to_the_moment else Ring(session, key, NEWEST, clock)
        )

    @property
    def waiting(self) -> int:
        """How many have come that nobody has looked at."""
        return self._came.waiting

    def take(self, now_ns: int) -> list[Tuple[int, T]]:
        """Of what came since the last time, what counts: when it came and what it is, the oldest first."""
        commands = []
        for received in self._came.take():
            try:
                commands.append((received.received_ns, self._accept(now_ns, received)))
            except RefusedError as error:
                self._log(received, error)
        return commands

    def undeclare(self) -> None:
        """Nothing comes any more."""
        self._came.undeclare()

    def _accept(self, now_ns: int, received: Received) -> T:
        refusal = self.freshness.judge(now_ns, received.received_ns, len(received.payload), received.attachment)
        if refusal is not None:
            raise RefusedError(refusal.value)
        try:
            return self._convert(decode(self._topic.message, received.payload))
        except RefusedError:
            self.freshness.malformed()
            raise

    def _log(self, received: Received, error: RefusedError) -> None:
        sender = session_of(received.attachment)
        if sender not in self._logged and len(self._logged) < MOST_LOGGED:
            self._logged.add(sender)
            log.warning("%s: refused of %s, and from now on only counted: %s", received.key, sender or "nobody", error)
