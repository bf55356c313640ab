# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Sessions, what is put and heard, and who is alive: with real sessions on loopback."""

from __future__ import annotations

import logging
import socket
import time
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Iterator, Optional, Tuple

import pytest
import zenoh

from bus_lab import QUIET_S, Lab, Sink, free_port, until, wait_for_listener
from edgefusion.bus.feed import Feed
from edgefusion.bus.freshness import CommandLimits, Freshness, Refusal
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.joining import Joining
from edgefusion.bus.liveliness import Alive, declare_alive
from edgefusion.bus.publisher import CommandPublisher, Publisher
from edgefusion.bus.ring import Ring
from edgefusion.bus.router import open_router
from edgefusion.bus.session import UnreachableError, open_client, open_member
from edgefusion.bus.subscriber import Received, Subscriber
from edgefusion.bus.tags import SampleTag, Tagger, read_tag
from edgefusion.bus.topics import CMD_VEL, DETECTIONS_DETAIL, HEARTBEAT, IMAGE, MISSION, ODOM, TOPICS, Urgency
from edgefusion.config.bus import BusConfig
from edgefusion.errors import RefusedError
from edgefusion.messages import ros_name
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.geometry_msgs import Twist, Vector3
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.service.base_inbox import BaseInbox
from edgefusion.types import Twist2D

MS = 1_000_000
LIMITS = CommandLimits(4096, 1e6, burst=100_000)
AHEAD = encode(Twist(Vector3(x=0.3)))

Sample = Tuple[Optional[bytes], bytes]
"""Attachment and payload."""


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def lab(stack: ExitStack) -> Lab:
    lab = Lab(stack)
    lab.router()
    return lab


def connected(publisher: Publisher) -> Publisher:
    """Once somebody listens."""
    until(lambda: publisher.wanted(time.monotonic_ns()))
    return publisher


def test_what_is_put_is_heard_byte_for_byte_with_its_stamp_type_and_number(lab: Lab) -> None:
    publisher = Publisher(lab.member(), "robot", MISSION, Tagger("me"), "boot-7")
    subscriber = Subscriber(lab.client(), "robot/mission", newest=10, clock=lambda: 42)
    message = String('{"state":"driving"}')
    connected(publisher).put(message, 123)
    received = subscriber.wait(5)
    assert received is not None and received.attachment is not None
    assert (received.key, received.payload) == ("robot/mission", encode(message))
    assert received.encoding.endswith("std_msgs/msg/String")
    assert received.received_ns == 42
    assert read_tag(SampleTag, received.attachment) == SampleTag("boot-7", 123, "me", 0)


def test_every_topic_can_be_put_and_says_its_type(lab: Lab) -> None:
    robot, sink = lab.member(), Sink(lab.client(), "robot/**")
    for topic in TOPICS.values():
        connected(Publisher(robot, "robot", topic, Tagger(), "boot")).put(topic.message(), 0)
    until(lambda: len(sink.samples) == len(TOPICS))
    for sample in sink.samples:
        topic = TOPICS[str(sample.key_expr)[len("robot/") :]]
        assert str(sample.encoding).endswith(f";{ros_name(topic.message)}")
        assert sample.congestion_control == zenoh.CongestionControl.DROP
        assert sample.express == (topic.urgency in (Urgency.COMMAND, Urgency.SOON))
        decode(topic.message, sample.payload.to_bytes())


def test_the_newest_are_kept_and_the_others_counted(lab: Lab) -> None:
    publisher = Publisher(lab.member(), "robot", ODOM, Tagger(), "boot")
    subscriber = Subscriber(lab.client(), "robot/odom", newest=3)
    connected(publisher)
    for number in range(10):
        publisher.put_bytes(b"%d" % number, number)
    until(lambda: subscriber.received == 10)
    assert [received.payload for received in subscriber.take()] == [b"7", b"8", b"9"]
    assert (subscriber.dropped, subscriber.take()) == (7, [])


def test_waiting_gives_the_oldest_or_nothing_in_time(lab: Lab) -> None:
    publisher = Publisher(lab.member(), "robot", ODOM, Tagger(), "boot")
    subscriber = Subscriber(lab.client(), "robot/odom", newest=2)
    assert subscriber.wait(0.01) is None
    connected(publisher)
    for number in range(2):
        publisher.put_bytes(b"%d" % number, number)
    until(lambda: subscriber.received == 2)
    assert [getattr(subscriber.wait(1), "payload", None) for _ in range(2)] == [b"0", b"1"]
    assert subscriber.wait(0) is None


def test_a_wake_that_fails_is_logged_once_counted_and_nothing_is_lost(
    lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> None:
        raise RuntimeError("on purpose")

    publisher = Publisher(lab.member(), "robot", ODOM, Tagger(), "boot")
    subscriber = Subscriber(lab.client(), "robot/odom", newest=10, wake=fail)
    connected(publisher)
    for number in range(3):
        publisher.put_bytes(b"x", number)
    until(lambda: subscriber.failures == 3)
    assert len(subscriber.take()) == 3
    assert len([record for record in caplog.records if record.levelno == logging.ERROR]) == 1


def test_nothing_is_wanted_while_nobody_listens_and_then_at_the_rate_that_is_set(lab: Lab) -> None:
    publisher = Publisher(lab.member(), "robot", IMAGE, Tagger(), "boot", max_hz=10)
    time.sleep(QUIET_S)
    assert not publisher.wanted(0)
    subscriber = Subscriber(lab.client(), "robot/image/compressed")
    until(lambda: publisher.wanted(0))
    times_ms = [ms for ms in range(1, 10_000) if publisher.wanted(ms * MS)]
    assert len(times_ms) == 99
    assert publisher.wanted(60_000 * MS)
    after_a_pause_ms = [ms for ms in range(60_001, 61_000) if publisher.wanted(ms * MS)]
    assert len(after_a_pause_ms) <= 11
    assert after_a_pause_ms[-1] >= 60_900
    subscriber.undeclare()
    until(lambda: not publisher.wanted(10**15))


def test_who_is_alive_is_known_also_to_who_comes_later(lab: Lab) -> None:
    base, vision, changes = lab.member(), lab.member(), []
    tokens = [declare_alive(base, "robot", "base"), declare_alive(vision, "robot", "vision")]
    alive = Alive(lab.client(), "robot", lambda: changes.append(1))
    until(lambda: alive.components == {"base", "vision"})
    vision.close()
    until(lambda: alive.components == {"base"})
    tokens[0].undeclare()
    until(lambda: not alive.components)
    assert len(changes) == 4


def test_a_client_without_a_router_says_so_in_time() -> None:
    started_s = time.monotonic()
    with pytest.raises(UnreachableError, match="no router let us in"):
        open_client(f"tcp/127.0.0.1:{free_port()}", timeout_s=0.2)
    assert time.monotonic() - started_s < 5


def test_a_router_on_a_port_that_is_taken_says_which() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(OSError, match=f"cannot listen on {endpoint}"):
            open_router(BusConfig(listen=(endpoint,)))


def test_who_comes_before_the_router_joins_it_when_it_is_there(stack: ExitStack) -> None:
    lab, joined = Lab(stack), []
    joining = Joining(lambda: open_member(lab.config, timeout_s=0.05), joined.append, pause_s=0.01)
    joining.begin()
    time.sleep(QUIET_S)
    assert not joined
    lab.router()
    until(lambda: joined)
    assert list(joined[0].info.routers_zid())
    joining.end()
    assert joined[0].is_closed()


def test_who_gives_up_joining_ends_and_what_fails_otherwise_is_told(stack: ExitStack) -> None:
    lab = Lab(stack)
    waiting = Joining(lambda: open_member(lab.config, timeout_s=0.05), pytest.fail, pause_s=100.0)
    waiting.begin()
    waiting.end()
    keys = BusConfig(listen=("tls/127.0.0.1:7447",), keys="/nowhere")
    wrong = Joining(lambda: open_member(keys), pytest.fail)
    wrong.begin()
    until(lambda: wrong.failure)
    assert isinstance(wrong.failure, RefusedError)
    wrong.end()


def test_a_feed_takes_what_is_stamped_by_the_clock_it_reckons_with(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    robot, other = lab.member(), lab.member()
    own = Feed(robot, "robot", MISSION, lambda message: message.data, "boot-1", newest=10)
    any_clock = Feed(robot, "robot", MISSION, lambda message: message.data, None, newest=10)
    for clock in ("boot-1", "boot-2", "boot-1"):
        connected(Publisher(other, "robot", MISSION, Tagger(), clock)).put(String(clock), 5)
    other.put("robot/mission", encode(String("no stamp")))
    Publisher(other, "robot", MISSION, Tagger(), "boot-1").put_bytes(b"no message", 5)
    until(lambda: (own.waiting, any_clock.waiting) == (5, 5))
    assert [(tag.stamp_ns, text) for tag, text in own.take()] == [(5, "boot-1")] * 2
    assert [text for _, text in any_clock.take()] == ["boot-1", "boot-2", "boot-1"]
    assert (own.refused, any_clock.refused) == (3, 2)
    warnings = [record.getMessage() for record in caplog.records]
    assert len(warnings) == 2
    assert "expected stamps of the clock boot-1, got one of boot-2" in warnings[0]


def test_a_feed_takes_nothing_from_the_future_of_its_clock(lab: Lab) -> None:
    feed = Feed(lab.member(), "robot", MISSION, lambda message: message.data, "boot", newest=10, clock=lambda: 1000)
    publisher = connected(Publisher(lab.member(), "robot", MISSION, Tagger(), "boot"))
    for stamp_ns in (1000, 2_000_001_000, 999, 50_000_000):
        publisher.put(String(str(stamp_ns)), stamp_ns)
    until(lambda: feed.waiting == 4)
    assert [text for _, text in feed.take()] == ["1000", "999", "50000000"]
    assert feed.reason == "expected a stamp of before it came, got one of 2.000 s later"


def test_base_says_of_what_vision_tells_it_why_it_does_not_count(lab: Lab) -> None:
    inbox, client = BaseInbox(lab.member(), lab.config, "boot-1"), lab.member()
    publisher = connected(Publisher(client, "robot", DETECTIONS_DETAIL, Tagger(), "boot-2"))
    publisher.put(from_detections_detail(7, []), 7)
    until(lambda: (inbox.from_vision(), inbox.refused())[1])
    assert inbox.refused() == {"detections/detail refused": "1: expected stamps of the clock boot-1, got one of boot-2"}
    assert inbox.from_vision().detections_ns is None


def test_a_ring_keeps_the_newest_which_came_when_it_was_looked_at_before(lab: Lab) -> None:
    times_ns = iter((10, 20, 30, 40))
    robot, client = lab.member(), lab.client()
    ring = Ring(robot, "robot/cmd_vel", 3, lambda: next(times_ns))  # at 10
    after = Sink(robot, "robot/operator/heartbeat")
    wait_for_listener(client, "robot/operator/heartbeat")
    assert ring.take() == []  # at 20
    client.put("robot/cmd_vel", b"0", attachment=b"tag", encoding="text/plain")
    until(lambda: (client.put("robot/operator/heartbeat", b""), after.samples)[1])
    assert ring.take() == [Received("robot/cmd_vel", b"0", b"tag", "text/plain", 20)]  # at 30
    for number in range(10):
        client.put("robot/cmd_vel", b"%d" % number)
    after.samples.clear()
    until(lambda: (client.put("robot/operator/heartbeat", b""), after.samples)[1])
    assert [(each.payload, each.received_ns) for each in ring.take()] == [(b"7", 30), (b"8", 30), (b"9", 30)]


def test_of_a_session_that_was_closed_a_ring_has_nothing(lab: Lab) -> None:
    robot = lab.member()
    ring = Ring(robot, "robot/cmd_vel", 3)
    robot.close()
    assert ring.take() == []


def test_a_heartbeat_counts_from_when_it_came_also_where_the_loop_looks_late(lab: Lab) -> None:
    heard, robot = [], lab.member()
    helm = SimpleNamespace(heartbeat=heard.append)
    inbox = BaseInbox(robot, lab.config, "boot")
    publisher = CommandPublisher(lab.client(), "robot", HEARTBEAT, Tagger(), 60_000)
    until(lambda: publisher.heard)
    time.sleep(0.05)
    put_ns = time.monotonic_ns()
    publisher.put(String())
    time.sleep(0.05)
    until(lambda: (inbox.command(helm, time.monotonic_ns()), heard)[1])
    assert heard[0] >= put_ns


def commands_of(robot: zenoh.Session, limits: CommandLimits = LIMITS) -> Inbox[Twist2D]:
    """All of which come at 0."""
    return Inbox(robot, "robot", CMD_VEL, to_cmd_vel, Freshness(limits), clock=lambda: 0)


def put_one_by_one(client: zenoh.Session, inbox: Inbox[Twist2D], *samples: Sample) -> None:
    wait_for_listener(client, "robot/cmd_vel")
    for count, (attachment, payload) in enumerate(samples, start=1):
        client.put("robot/cmd_vel", payload, attachment=attachment)
        until(lambda: inbox.waiting == count)  # noqa: B023  # it is called at once


def test_a_command_arrives_as_what_the_robot_works_with(lab: Lab) -> None:
    inbox, client = commands_of(lab.member()), lab.client()
    wait_for_listener(client, "robot/cmd_vel")
    CommandPublisher(client, "robot", CMD_VEL, Tagger(), 200).put(Twist(Vector3(x=0.3), Vector3(z=-0.1)))
    until(lambda: inbox.waiting)
    assert inbox.take(6) == [(0, Twist2D(0.3, -0.1))]
    assert inbox.take(7) == []


def test_commands_that_do_not_count_are_counted_and_logged_once_for_each_sender(
    lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    inbox, tagger = commands_of(lab.member()), Tagger("careless")
    good, late = tagger.command(200), tagger.command(1)
    put_one_by_one(
        lab.client(),
        inbox,
        (None, AHEAD),
        (good, AHEAD),
        (good, AHEAD),
        (late, AHEAD),
        (tagger.command(200), AHEAD[:-1]),
        (tagger.command(200), encode(Twist(Vector3(x=float("nan"))))),
        (tagger.command(200), AHEAD + b"\0" * 4096),
    )
    assert [twist for _, twist in inbox.take(100 * MS)] == [Twist2D(0.3, 0)]
    refusals = (Refusal.UNTAGGED, Refusal.REPLAYED, Refusal.EXPIRED, Refusal.OVERSIZED)
    assert inbox.freshness.counts == {Refusal.MALFORMED: 2, **{refusal: 1 for refusal in refusals}}
    warnings = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert len(warnings) == 2
    assert "refused of careless" in warnings[1]


def test_plain_ros_counts_where_it_is_allowed(lab: Lab) -> None:
    inbox = commands_of(lab.member(), CommandLimits(4096, 1e6, allow_plain=True))
    put_one_by_one(lab.client(), inbox, (None, AHEAD))
    assert [twist for _, twist in inbox.take(0)] == [Twist2D(0.3, 0)]


def test_a_key_that_is_deleted_is_no_command(lab: Lab) -> None:
    inbox, client = commands_of(lab.member()), lab.client()
    wait_for_listener(client, "robot/cmd_vel")
    client.delete("robot/cmd_vel")
    put_one_by_one(client, inbox, (None, b"x"))
    assert inbox.waiting == 1
