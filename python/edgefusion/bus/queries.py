# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Queries on the bus: a request in JSON, and an answer that is accepted, or refused with the reason."""

from __future__ import annotations

import logging
import threading
import time
from collections import OrderedDict
from contextlib import suppress
from queue import Full, Queue
from typing import Callable, Generic, Optional, Tuple, Type, TypeVar

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

MOST_WAITING = 16
"""So many requests wait for the one that is being done."""

MOST_REMEMBERED = 64
"""So many answers are kept for who sends the same request again."""

AGAIN_S = 0.1
"""After so long a request that nobody answered is sent again: the router drops what comes too fast."""


class Service(Generic[R]):
    """Answers the queries on a key, in a thread that is this key's alone.

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
        self._given: OrderedDict[Tuple[Optional[bytes], bytes], Answer] = OrderedDict()
        self._waiting: Queue[Optional[Tuple[int, zenoh.Query]]] = Queue(MOST_WAITING)
        threading.Thread(target=self._serve, name=key, daemon=True).start()
        guarded: Guarded[zenoh.Query] = Guarded(key, self._take)
        self._queryable: Declared = session.declare_queryable(key, guarded.handler)

    def undeclare(self) -> None:
        """Nobody answers any more; those who wait still get their answers."""
        self._queryable.undeclare()
        self._waiting.put(None)

    def _take(self, query: zenoh.Query) -> None:
        """One for whom there is no room is not answered, and asks again."""
        with suppress(Full):
            self._waiting.put_nowait((self._clock(), query))

    def _serve(self) -> None:
        respond: Guarded[Tuple[int, zenoh.Query]] = Guarded(self._key, self._respond)
        while True:
            waiting = self._waiting.get()
            if waiting is None:
                return
            respond(waiting)

    def _respond(self, waiting: Tuple[int, zenoh.Query]) -> None:
        received_ns, query = waiting
        with query:  # whose end tells the asker that nothing more comes
            payload = b"" if query.payload is None else query.payload.to_bytes()
            attachment = None if query.attachment is None else query.attachment.to_bytes()
            answer = self._answer(received_ns, payload, attachment)
            answer = msgspec.structs.replace(answer, stamp_ns=self._clock())
            query.reply(self._key, msgspec.json.encode(answer), encoding=zenoh.Encoding.APPLICATION_JSON)

    def _answer(self, received_ns: int, payload: bytes, attachment: Optional[bytes]) -> Answer:
        refusal = self.freshness.judge(self._clock(), received_ns, len(payload), attachment)
        if refusal is Refusal.REPLAYED and (attachment, payload) in self._given:
            return self._given[attachment, payload]  # of which the first answer was lost, perhaps: it is done once
        if refusal is not None:
            return Answer(False, refusal.value)
        answer = self._given[attachment, payload] = self._done(payload)
        if len(self._given) > MOST_REMEMBERED:
            self._given.popitem(last=False)
        return answer

    def _done(self, payload: bytes) -> Answer:
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


def ask(session: zenoh.Session, key: str, request: msgspec.Struct, tagger: Tagger, timeout_s: float = 2.0) -> Answer:
    """The answer of a robot that has accepted the request.

    Where nobody answers it is sent again, under the same number: the robot does it once, and answers again.
    Raises RefusedError with the reason where it was not accepted, UnreachableError where nobody answers in time.
    """
    payload, tag = msgspec.json.encode(request), tagger.command(max(1, round(timeout_s * 1e3)))
    end_s = time.monotonic() + timeout_s
    while True:
        answer = _ask_once(session, key, payload, tag, max(0.01, end_s - time.monotonic()))
        if answer is not None:
            break
        if time.monotonic() + AGAIN_S > end_s:
            raise UnreachableError(f"{key}: nobody answered: is the base running, and may these keys command?")
        time.sleep(AGAIN_S)
    if not answer.accepted:
        raise RefusedError(f"{key}: refused: {answer.reason}")
    return answer


def _ask_once(session: zenoh.Session, key: str, payload: bytes, tag: bytes, timeout_s: float) -> Optional[Answer]:
    replies = session.get(
        key,
        payload=payload,
        encoding=zenoh.Encoding.APPLICATION_JSON,
        attachment=tag,
        timeout=timeout_s,
        priority=zenoh.Priority.REAL_TIME,
        express=True,
    )
    for reply in replies:
        if reply.ok is not None:
            return read_json(Answer, reply.ok.payload.to_bytes())
    return None
