# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The clock that everything on a robot's bus is stamped with: told to who is on another computer, and read there."""

from __future__ import annotations

from typing import NamedTuple, Optional

import msgspec
import zenoh

from edgefusion.bus.callbacks import Guarded
from edgefusion.bus.requests import read_json
from edgefusion.bus.session import Declared
from edgefusion.bus.topics import CLOCK, key_of
from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError


class Reading(NamedTuple):
    """clock: the id of the other clock. ahead_ns: so much more than ours it says, give or take error_ns, which is half
    of what question and answer took together."""

    clock: str
    ahead_ns: int
    error_ns: int


class _Answer(msgspec.Struct):
    clock: str
    now_ns: int


class ClockTeller:
    """Answers whoever asks what this clock says. clock_id: its name."""

    def __init__(self, session: zenoh.Session, robot: str, clock_id: str, clock: Clock = system_clock) -> None:
        self._key, self._clock_id, self._clock = key_of(robot, CLOCK), clock_id, clock
        guarded: Guarded[zenoh.Query] = Guarded(self._key, self._answer)
        self._queryable: Declared = session.declare_queryable(self._key, guarded.handler)

    def undeclare(self) -> None:
        """Nobody answers any more."""
        self._queryable.undeclare()

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            payload = msgspec.json.encode(_Answer(self._clock_id, self._clock()))
            query.reply(self._key, payload, encoding=zenoh.Encoding.APPLICATION_JSON)


def read_clock(session: zenoh.Session, robot: str, timeout_s: float, clock: Clock = system_clock) -> Optional[Reading]:
    """None where nobody answers in time, or not what a clock says."""
    asked_ns = clock()
    replies = session.get(key_of(robot, CLOCK), timeout=timeout_s, priority=zenoh.Priority.REAL_TIME, express=True)
    for reply in replies:
        heard_ns = clock()
        if reply.ok is None:
            continue
        try:
            answer = read_json(_Answer, reply.ok.payload.to_bytes())
        except RefusedError:
            continue
        error_ns = (heard_ns - asked_ns + 1) // 2
        return Reading(answer.clock, answer.now_ns - asked_ns - error_ns, error_ns)
    return None
