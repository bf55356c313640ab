# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the bus against sessions on loopback: Z1, Z5, Z7 and Z8 in small; in full by `make faults`."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import Iterator

import pytest

from bus_lab import QUIET_S, SOON_S, Lab, Sink, make_keys, until
from edgefusion.bus.freshness import CommandLimits, Freshness, Refusal, limits_of
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.publisher import CommandPublisher, Publisher
from edgefusion.bus.queries import Service, ask
from edgefusion.bus.requests import StopRequest
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL, IMAGE, MISSION, ODOM
from edgefusion.messages.geometry_msgs import Twist
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_cmd_vel import to_cmd_vel

LIMITS = CommandLimits(4096, 1000, burst=1000)


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_keys(tmp_path_factory.mktemp("keys"))


@pytest.fixture
def keyed(keys: Path) -> Iterator[Lab]:
    with ExitStack() as stack:
        lab = Lab(stack, keys, max_command_hz=1000.0)
        lab.router()
        yield lab


def connected(publisher: Publisher) -> Publisher:
    """Once somebody listens."""
    until(lambda: publisher.wanted(time.monotonic_ns()))
    return publisher


def test_z1_a_router_that_dies_costs_its_clients_nothing_and_is_found_again() -> None:
    with ExitStack() as stack:
        lab = Lab(stack)
        router = lab.router()
        robot = lab.member()
        publisher = Publisher(robot, "robot", MISSION, Tagger(), "boot")
        subscriber = Subscriber(lab.client(), "robot/mission", newest=1000)
        until(lambda: (publisher.put(String("first"), 0), subscriber.received)[1])
        router.close()
        until(lambda: not list(robot.info.routers_zid()))
        publisher.put(String("into a dead link"), 0)
        subscriber.take()
        lab.router()
        until(lambda: (time.sleep(0.01), publisher.put(String("again"), 0), subscriber.take())[2])


def test_z5_of_a_viewers_commands_none_arrives_of_an_operators_all(keyed: Lab) -> None:
    heard = Sink(keyed.member(), "robot/cmd_vel")
    viewer, operator = keyed.client("viewer"), keyed.client("operator")
    until(lambda: (operator.put("robot/cmd_vel", b"first"), heard.samples)[1])
    for number in range(100):
        viewer.put("robot/cmd_vel", b"viewer")
        operator.put("robot/cmd_vel", b"%d" % number)
        until(lambda: heard.payloads()[-1] == b"%d" % number)  # noqa: B023  # it is called at once
    assert [each for each in heard.payloads() if each != b"first"] == [b"%d" % number for number in range(100)]


def test_z7_of_a_flood_no_more_counts_than_may_and_a_stop_gets_through(keys: Path) -> None:
    with ExitStack() as stack:
        lab = Lab(stack, keys, max_command_hz=10.0)
        lab.router()
        robot, operator, asked = lab.member(), lab.client("operator"), []
        inbox = Inbox(robot, "robot", CMD_VEL, to_cmd_vel, Freshness(limits_of(lab.config)))
        service = Service(robot, "robot/stop", StopRequest, asked.append, Freshness(LIMITS))
        publisher = CommandPublisher(operator, "robot", CMD_VEL, Tagger(), 1000)
        until(lambda: publisher.heard)
        start_s = time.monotonic()
        for _ in range(30):
            for _ in range(100):
                publisher.put(Twist())
            time.sleep(0.002)
            inbox.take(time.monotonic_ns())
        ask(operator, "robot/stop", StopRequest(), Tagger(), timeout_s=SOON_S)
        assert asked
        assert service.freshness.accepted == 1
        inbox.take(time.monotonic_ns())
        assert 0 < inbox.freshness.accepted <= 10 + 10 * (time.monotonic() - start_s)
        assert inbox.freshness.counts[Refusal.TOO_MANY] > 0


def test_z7_a_flood_leaves_no_more_behind_than_what_is_kept(lab: Lab) -> None:
    subscriber = Subscriber(lab.member(), "robot/odom", newest=16)
    publisher = connected(Publisher(lab.client(), "robot", ODOM, Tagger(), "boot"))
    until(lambda: ([publisher.put_bytes(b"x" * 200, 0) for _ in range(100)], subscriber.received >= 1000)[1])
    time.sleep(QUIET_S)
    assert len(subscriber.take()) == 16
    assert subscriber.dropped == subscriber.received - 16


def test_z8_a_slow_subscriber_costs_the_others_nothing(lab: Lab) -> None:
    publisher = Publisher(lab.member(), "robot", IMAGE, Tagger(), "boot")
    fast = Subscriber(lab.client(), "robot/image/compressed", newest=1000)
    slow = Subscriber(lab.client(), "robot/image/compressed", wake=lambda: time.sleep(0.1))
    connected(publisher)
    until(lambda: (publisher.put_bytes(b"first", 0), fast.received and slow.received)[1])
    time.sleep(QUIET_S)
    fast.take()
    for number in range(100):
        publisher.put_bytes(b"x" * 30_000, number)
        until(lambda: fast.waiting > number)  # noqa: B023  # it is called at once
    assert slow.received < 100
