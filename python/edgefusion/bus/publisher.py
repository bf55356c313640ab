# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Publishers: of what the robot tells, with its stamp, and of what an operator commands, with how long it is worth.

Neither waits: what a full line cannot take is dropped.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any, Mapping, Tuple

import zenoh

from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import Topic, Urgency, key_of
from edgefusion.messages import Message, ros_name
from edgefusion.messages.cdr import encode

_PRIORITIES: Mapping[Urgency, Tuple[zenoh.Priority, bool]] = MappingProxyType(
    {
        Urgency.COMMAND: (zenoh.Priority.REAL_TIME, True),
        Urgency.SOON: (zenoh.Priority.DATA_HIGH, True),
        Urgency.USUAL: (zenoh.Priority.DATA, False),
        Urgency.BULK: (zenoh.Priority.BACKGROUND, False),
    }
)


class Publisher:
    """Of a topic of the robot's. clock: the id of the clock whose stamps it puts; max_hz: `wanted` keeps to it.

    For one thread.
    """

    def __init__(
        self, session: zenoh.Session, robot: str, topic: Topic, tagger: Tagger, clock: str, max_hz: float = 1e9
    ) -> None:
        self._publisher = _declare(session, robot, topic)
        self._tagger, self._clock = tagger, clock
        self._period_ns = round(1e9 / max_hz)
        self._due_ns = 0

    def wanted(self, now_ns: int) -> bool:
        """Whether somebody listens and it is time for the next sample: else it need not be made."""
        if now_ns < self._due_ns or not self._publisher.matching_status.matching:
            return False
        # On its own beat, so that the mean rate is kept, but without making up for a pause.
        self._due_ns = max(self._due_ns + self._period_ns, now_ns - self._period_ns)
        return True

    def put(self, message: Message, stamp_ns: int) -> None:
        """Raises WireError for a message that cannot be written."""
        self.put_bytes(encode(message), stamp_ns)

    def put_bytes(self, payload: bytes, stamp_ns: int) -> None:
        """The message as CDR."""
        self._publisher.put(payload, attachment=self._tagger.sample(self._clock, stamp_ns))

    def undeclare(self) -> None:
        self._publisher.undeclare()


class CommandPublisher:
    """Of a topic of commands. ttl_ms: so old a command may become."""

    def __init__(self, session: zenoh.Session, robot: str, topic: Topic, tagger: Tagger, ttl_ms: int) -> None:
        self._publisher = _declare(session, robot, topic)
        self._tagger, self._ttl_ms = tagger, ttl_ms

    @property
    def heard(self) -> bool:
        """Whether somebody listens whom these keys may command."""
        return bool(self._publisher.matching_status.matching)

    def put(self, message: Message) -> None:
        """Raises WireError for a message that cannot be written."""
        self._publisher.put(encode(message), attachment=self._tagger.command(self._ttl_ms))

    def undeclare(self) -> None:
        self._publisher.undeclare()


def _declare(session: zenoh.Session, robot: str, topic: Topic) -> Any:
    """A zenoh.Publisher, of which its stubs say the wrong things."""
    priority, express = _PRIORITIES[topic.urgency]
    return session.declare_publisher(
        key_of(robot, topic.name),
        encoding=zenoh.Encoding.APPLICATION_CDR.with_schema(ros_name(topic.message)),
        congestion_control=zenoh.CongestionControl.DROP,
        priority=priority,
        express=express,
    )
