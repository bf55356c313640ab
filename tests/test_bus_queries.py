# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Queries: every one that reaches the robot is answered, accepted or refused, with the reason. The key of most is one
whose rate the router does not limit."""

from __future__ import annotations

import logging
import threading
from typing import Any, Callable, Optional

import msgspec
import pytest
import zenoh

from bus_lab import Lab, until
from edgefusion.bus.freshness import CommandLimits, Freshness, Refusal
from edgefusion.bus.queries import MOST_WAITING, Service, ask
from edgefusion.bus.requests import Answer, GotoRequest, ResumeRequest, StopRequest, read_json
from edgefusion.bus.tags import Tagger
from edgefusion.errors import RefusedError

LIMITS = CommandLimits(4096, 1e6, burst=100_000)


def serve(lab: Lab, handle: Callable[[Any], None], limits: CommandLimits = LIMITS) -> Service[StopRequest]:
    return Service(lab.member(), "robot/question", StopRequest, handle, Freshness(limits), clock=lambda: 77)


def accept(_: object) -> None:
    """Whatever it is."""


def raw(session: zenoh.Session, payload: bytes, tag: Optional[bytes]) -> Answer:
    """As a client sends it that is not ours."""
    replies = session.get("robot/question", payload=payload, attachment=tag, timeout=5.0)
    (answer,) = [read_json(Answer, reply.ok.payload.to_bytes()) for reply in replies if reply.ok is not None]
    return answer


def test_what_is_accepted_is_done_once_and_answered_by_the_robots_clock(lab: Lab) -> None:
    asked = []
    service = serve(lab, asked.append)
    assert ask(lab.client(), "robot/question", StopRequest("a cat"), Tagger()) == Answer(True, "", 77)
    assert asked == [StopRequest("a cat")]
    assert service.freshness.accepted == 1


@pytest.mark.parametrize("error", [RefusedError("not now"), TimeoutError("not now")])
def test_what_the_robot_refuses_or_cannot_do_in_time_is_refused_with_the_reason(lab: Lab, error: Exception) -> None:
    def refuse(_: object) -> None:
        raise error

    service = serve(lab, refuse)
    with pytest.raises(RefusedError, match="robot/question: refused: not now"):
        ask(lab.client(), "robot/question", StopRequest(), Tagger())
    service.undeclare()


def test_a_handler_that_fails_is_logged_and_answered_without_its_secrets(
    lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(_: object) -> None:
        raise KeyError("a secret")

    service = serve(lab, fail)
    with pytest.raises(RefusedError, match=r"refused: failed: KeyError$"):
        ask(lab.client(), "robot/question", StopRequest(), Tagger())
    assert [record.levelno for record in caplog.records] == [logging.ERROR]
    service.undeclare()


@pytest.mark.parametrize(
    "payload",
    [b"", b"{", b"[]", b"\xff", b'{"reason":1}', b'{"more":1}', b'{"version":2}', b"[" * 4000, rb'{"reason":"a\n"}'],
)
def test_what_is_no_request_is_refused_as_malformed(lab: Lab, payload: bytes) -> None:
    service = serve(lab, accept)
    answer = raw(lab.client(), payload, Tagger().command(1000))
    assert not answer.accepted
    assert answer.reason.startswith("malformed: StopRequest: ")
    assert (service.freshness.accepted, service.freshness.counts) == (0, {Refusal.MALFORMED: 1})


def test_a_request_counts_once_and_not_without_a_number(lab: Lab) -> None:
    asked = []
    service, client, tag = serve(lab, asked.append), lab.client(), Tagger().command(1000)
    assert raw(client, b"{}", tag).accepted
    assert raw(client, b"{ }", tag).reason == "replayed"
    assert raw(client, b"{}", None).reason == "without session and number"
    assert raw(client, b"{}", b"junk").reason == "a tag that is none"
    assert len(asked) == 1
    service.undeclare()


def test_who_lost_the_answer_and_asks_again_gets_it_without_its_being_done_again(lab: Lab) -> None:
    refusals = [None, RefusedError("not now")]

    def answer(_: object) -> None:
        refusal = refusals.pop(0)
        if refusal is not None:
            raise refusal

    service, client, tagger = serve(lab, answer), lab.client(), Tagger()
    for accepted in (True, False):
        tag = tagger.command(1000)
        first, again = raw(client, b"{}", tag), raw(client, b"{}", tag)
        assert first == again
        assert first.accepted is accepted
    assert refusals == []
    service.undeclare()


def test_of_too_many_requests_the_rest_is_refused(lab: Lab) -> None:
    service, client, tagger = serve(lab, accept, CommandLimits(4096, 1, burst=3)), lab.client(), Tagger()
    answers = [raw(client, b"{}", tagger.command(1000)) for _ in range(5)]
    assert [answer.accepted for answer in answers] == [True, True, True, False, False]
    assert answers[-1].reason == "too many"
    service.undeclare()


def test_a_stop_does_not_wait_for_another_request_that_takes_long(lab: Lab) -> None:
    robot, busy, free = lab.member(), threading.Event(), threading.Event()

    def slow(_: object) -> None:
        busy.set()
        free.wait(5)

    services = [
        Service(robot, "robot/resume", ResumeRequest, slow, Freshness(LIMITS)),
        Service(robot, "robot/question", StopRequest, accept, Freshness(LIMITS)),
    ]
    client, tagger = lab.client(), Tagger()
    waiting = threading.Thread(target=lambda: ask(client, "robot/resume", ResumeRequest(), tagger, 5))
    waiting.start()
    assert busy.wait(5)
    ask(client, "robot/question", StopRequest(), tagger)
    assert waiting.is_alive()
    free.set()
    waiting.join()
    assert [service.freshness.accepted for service in services] == [1, 1]


def test_more_requests_than_can_wait_are_not_kept(lab: Lab) -> None:
    busy, free = threading.Event(), threading.Event()

    def slow(_: object) -> None:
        busy.set()
        free.wait(5)

    service, client, tagger = serve(lab, slow), lab.client(), Tagger()
    pending = [client.get("robot/question", payload=b"{}", attachment=tagger.command(60_000), timeout=5.0)]
    assert busy.wait(5)
    pending += [
        client.get("robot/question", payload=b"{}", attachment=tagger.command(60_000), timeout=5.0)
        for _ in range(MOST_WAITING + 5)
    ]
    assert not any(list(replies) for replies in pending[-5:])
    free.set()
    assert all(list(replies) for replies in pending[:-5])
    assert service.freshness.accepted == 1 + MOST_WAITING


def test_a_request_is_sent_again_until_there_is_somebody_to_answer(lab: Lab) -> None:
    client, services = lab.client(), []
    late = threading.Timer(0.2, lambda: services.append(serve(lab, accept)))
    late.start()
    ask(client, "robot/question", StopRequest(), Tagger(), timeout_s=5)
    until(lambda: services)
    late.join()


def test_version_and_limits_of_requests() -> None:
    assert read_json(GotoRequest, b'{"goals":[{"x_m":1,"y_m":2}]}').version == 1
    for bad in (
        b'{"goals":[]}',
        b'{"goals":[{"x_m":1}]}',
        b'{"goals":[{"x_m":1e9,"y_m":2}]}',
        b'{"goals":[{"x_m":NaN,"y_m":2}]}',
        b'{"goals":[{"x_m":1,"y_m":2,"frame":"map"}]}',
        b'{"goals":[{"x_m":1,"y_m":2}],"version":2}',
        msgspec.json.encode({"goals": [{"x_m": 1, "y_m": 2}] * 101}),
        rb'{"goals":[{"x_m":1,"y_m":2,"id":"\u001b[2J"}]}',
        rb'{"goals":[{"x_m":1,"y_m":2}],"inspect":["chair\u0000"]}',
    ):
        with pytest.raises(RefusedError, match="GotoRequest"):
            read_json(GotoRequest, bad)
