# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Queries on the bus: a request in JSON, and an answer that is accepted, or refused with the reason."""

from __future__ import annotations

import logging
from typing import Callable, Generic, Optional, Type, TypeVar

import msgspec
import zenoh

from edgefusion.bus.callbacks import Guarded
from edgefusion.bus.freshness import Freshness, Refusal
from edgefusion.bus.requests import Answer, read_json
from edgefusion.bus.session import Declared, UnreachableError
from edgefusion.bus.tags import Tagger
from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError

log = logging.getLogger(__name__)

R = TypeVar("R", bound=msgspec.Struct)


class Service(Generic[R]):
    """Answers the queries on a key, in a thread of Zenoh's that is this key's alone.

    handle: does what is asked for, or raises RefusedError or TimeoutError with what is answered then.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        kind: Type[R],
        handle: Callable[[R], None],
        freshness: Freshness,
        clock: Clock = system_clock,
    ) -> None:
        self._key, self._kind, self._handle = key, kind, handle
        self.freshness, self._clock = freshness, clock
        guarded: Guarded[zenoh.Query] = Guarded(key, self._take)
        self._queryable: Declared = session.declare_queryable(key, guarded)

    def undeclare(self) -> None:
        """Nobody answers any more."""
        self._queryable.undeclare()

    def _take(self, query: zenoh.Query) -> None:
        now_ns = self._clock()
        payload = b"" if query.payload is None else query.payload.to_bytes()
        attachment = None if query.attachment is None else query.attachment.to_bytes()
        answer = self._answer(now_ns, payload, attachment)
        query.reply(self._key, msgspec.json.encode(answer), encoding=zenoh.Encoding.APPLICATION_JSON)

    def _answer(self, now_ns: int, payload: bytes, attachment: Optional[bytes]) -> Answer:
        refusal = self.freshness.judge(now_ns, now_ns, len(payload), attachment)
        if refusal is not None:
            return Answer(False, refusal.value)
        try:
            request = read_json(self._kind, payload)
        except RefusedError as error:
            self.freshness.malformed()
            return Answer(False, f"{Refusal.MALFORMED.value}: {error}")
        try:
            self._handle(request)
        except (RefusedError, TimeoutError) as error:
            return Answer(False, str(error))
        except Exception as error:
            log.exception("%s: failed", self._key)
            return Answer(False, f"failed: {type(error).__name__}")
        return Answer(True)


def ask(session: zenoh.Session, key: str, request: msgspec.Struct, tagger: Tagger, timeout_s: float = 2.0) -> None:
    """Returns when the robot has accepted the request.

    Raises RefusedError with the reason where it has not, UnreachableError where nobody answers.
    """
    replies = session.get(
        key,
        payload=msgspec.json.encode(request),
        encoding=zenoh.Encoding.APPLICATION_JSON,
        attachment=tagger.command(max(1, round(timeout_s * 1e3))),
        timeout=timeout_s,
        priority=zenoh.Priority.REAL_TIME,
        express=True,
    )
    for reply in replies:
        if reply.ok is not None:
            answer = read_json(Answer, reply.ok.payload.to_bytes())
            if not answer.accepted:
                raise RefusedError(f"{key}: refused: {answer.reason}")
            return
    raise UnreachableError(f"{key}: nobody answered: is the base running, and may these keys command?")
