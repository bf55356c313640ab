# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who gets in and what they may do there: real TLS, with the keys that `edgefusion keys` makes.

Z9 as far as it needs no process of its own; the figures of the others are in tests/faults.
"""

from __future__ import annotations

import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Iterator

import pytest
import zenoh

import edgefusion
from bus_lab import QUIET_S, SOON_S, Lab, Sink, free_port, make_keys, until
from edgefusion.bus.freshness import CommandLimits, Freshness, Refusal
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.liveliness import Alive, declare_alive
from edgefusion.bus.publisher import CommandPublisher, Publisher
from edgefusion.bus.queries import Service, ask
from edgefusion.bus.requests import GoalRequest, GotoRequest, ResumeRequest, StopRequest
from edgefusion.bus.router import open_router
from edgefusion.bus.session import UnreachableError, open_client
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL, COMMANDS, GOTO, RESUME, SCAN, STOP, TOPICS
from edgefusion.config.bus import BusConfig
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import encode
from edgefusion.messages.geometry_msgs import Twist, Vector3
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.tools.doctor_sockets import own_sockets
from edgefusion.types import Twist2D

LIMITS = CommandLimits(4096, 1000, burst=1000)


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_keys(tmp_path_factory.mktemp("keys"))


@pytest.fixture
def lab(keys: Path) -> Iterator[Lab]:
    with ExitStack() as stack:
        lab = Lab(stack, keys, max_command_hz=1000.0)
        lab.router()
        yield lab


def put_everything(session: zenoh.Session, word: bytes) -> None:
    for topic in TOPICS.values():
        session.put(f"robot/{topic.name}", word)


def test_viewers_and_operators_read_everything(lab: Lab) -> None:
    robot = lab.member()
    sinks = [Sink(lab.client(role), "robot/**") for role in ("viewer", "operator")]
    publisher = Publisher(robot, "robot", SCAN, Tagger(), "boot")
    until(lambda: publisher.wanted(time.monotonic_ns()))
    until(lambda: (put_everything(robot, b"robot"), all(len(sink.samples) >= 2 * len(TOPICS) for sink in sinks))[1])
    for sink in sinks:
        assert {str(sample.key_expr) for sample in sink.samples} == {f"robot/{name}" for name in TOPICS}


def test_a_viewer_puts_nothing_and_an_operator_only_commands(lab: Lab) -> None:
    heard = Sink(lab.member(), "robot/**")
    viewer, operator = lab.client("viewer"), lab.client("operator")
    put_everything(viewer, b"viewer")
    until(lambda: (put_everything(operator, b"operator"), heard.samples)[1])
    time.sleep(QUIET_S)
    assert set(heard.payloads()) == {b"operator"}
    assert {str(sample.key_expr) for sample in heard.samples} == {f"robot/{topic.name}" for topic in COMMANDS}


def test_nobody_but_the_robot_deletes(lab: Lab) -> None:
    heard, operator, robot = Sink(lab.member(), "robot/**"), lab.client("operator"), lab.member()

    def deleted() -> set[str]:
        return {str(each.key_expr) for each in list(heard.samples) if each.kind == zenoh.SampleKind.DELETE}

    until(lambda: (operator.put("robot/cmd_vel", b"before"), heard.samples)[1])
    for topic in TOPICS.values():
        operator.delete(f"robot/{topic.name}")
    until(lambda: (operator.put("robot/cmd_vel", b"after"), b"after" in heard.payloads())[1])
    assert deleted() == set()
    until(lambda: (robot.delete("robot/scan"), deleted())[1] == {"robot/scan"})


def test_an_operator_is_answered_and_a_viewer_is_not_even_heard(lab: Lab) -> None:
    robot, asked = lab.member(), []
    requests = {GOTO: GotoRequest((GoalRequest(1, 2),)), STOP: StopRequest(), RESUME: ResumeRequest()}
    services = [
        Service(robot, f"robot/{name}", type(request), asked.append, Freshness(LIMITS))
        for name, request in requests.items()
    ]
    operator, viewer = lab.client("operator"), lab.client("viewer")
    for name, request in requests.items():
        with pytest.raises(UnreachableError, match="may these keys command"):
            ask(viewer, f"robot/{name}", request, Tagger(), timeout_s=0.15)
        assert not asked
        ask(operator, f"robot/{name}", request, Tagger(), timeout_s=SOON_S)
        assert asked.pop() == request
    assert [(service.freshness.accepted, dict(service.freshness.counts)) for service in services] == 3 * [(1, {})]


def test_nobody_else_answers_in_the_robots_place(lab: Lab) -> None:
    operator, viewer, caught = lab.client("operator"), lab.client("viewer"), []
    for impostor in (lab.client("operator"), viewer):
        impostor.declare_queryable("robot/stop", caught.append)
    time.sleep(QUIET_S)
    with pytest.raises(UnreachableError):
        ask(operator, "robot/stop", StopRequest(), Tagger(), timeout_s=0.15)
    assert not caught


def test_a_stop_right_after_anything_else_is_never_lost(keys: Path) -> None:
    """Sent at once and once: what the router drops for coming too fast, as a second stop, is not sent again here."""
    with ExitStack() as stack:
        lab = Lab(stack, keys, max_command_hz=1.0)
        lab.router()
        robot, operator, tagger, asked = lab.member(), lab.client("operator"), Tagger(), []
        services = [
            Service(robot, f"robot/{name}", kind, asked.append, Freshness(LIMITS))
            for name, kind in ((GOTO, GotoRequest), (STOP, StopRequest))
        ]
        ask(operator, "robot/stop", StopRequest(), Tagger(), timeout_s=SOON_S)
        for _ in range(50):
            time.sleep(0.002)
            operator.put("robot/cmd_vel", b"x")
            for name, payload in ((GOTO, b'{"goals":[{"x_m":1,"y_m":2}]}'), (STOP, b"{}")):
                answers = operator.get(f"robot/{name}", payload=payload, attachment=tagger.command(5000), timeout=5.0)
            assert list(answers)  # the stop's
        assert len([each for each in asked if isinstance(each, StopRequest)]) == 51
        assert services[1].freshness.counts == {}


def test_who_floods_with_what_is_no_stop_cannot_keep_out_the_stop_of_another(lab: Lab) -> None:
    asked, over = [], threading.Event()
    service = Service(lab.member(), "robot/stop", StopRequest, asked.append, Freshness(CommandLimits(4096, 50.0)))
    bad, good, tagger = lab.client("operator"), lab.client("operator"), Tagger()

    def flood() -> None:
        while not over.is_set():
            bad.get("robot/stop", payload=b"no stop", attachment=tagger.command(1000), timeout=0.5)
            time.sleep(0.0005)  # the others' threads are of the same interpreter

    flooding = threading.Thread(target=flood)
    flooding.start()
    try:
        until(lambda: service.freshness.counts[Refusal.MALFORMED] > 100)
        for _ in range(5):
            ask(good, "robot/stop", StopRequest(), Tagger(), timeout_s=SOON_S)
    finally:
        over.set()
        flooding.join()
    assert len(asked) == 5


def test_viewers_see_who_is_alive_and_cannot_pretend_to_be(lab: Lab) -> None:
    viewer = lab.client("viewer")
    alive = Alive(viewer, "robot")
    token = declare_alive(lab.member(), "robot", "base")
    other = lab.client("viewer")
    pretended = declare_alive(other, "robot", "vision")
    until(lambda: alive.components)
    time.sleep(QUIET_S)
    assert alive.components == {"base"}
    token.undeclare()
    until(lambda: not alive.components)
    pretended.undeclare()


def test_of_another_robots_keys_and_zenohs_own_nobody_gets_anything(lab: Lab) -> None:
    robot, viewer = lab.member(), lab.client("viewer")
    sink = Sink(viewer, "other/**")
    for _ in range(10):
        robot.put("other/scan", b"x")
    answers = [str(reply.ok.key_expr) for reply in viewer.get("@/**", timeout=0.5) if reply.ok is not None]
    own = str(viewer.info.zid())  # a session answers itself
    assert [key for key in answers if key.split("/")[1] != own] == []
    time.sleep(QUIET_S)
    assert not sink.samples


def test_keys_of_another_ca_no_keys_and_no_tls_get_nobody_in(lab: Lab, tmp_path: Path) -> None:
    foreign = make_keys(tmp_path / "foreign")
    mixed = tmp_path / "mixed"
    mixed.mkdir()
    for name, origin in (("ca.pem", lab.keys), ("cert.pem", foreign), ("key.pem", foreign)):
        (mixed / name).write_bytes((origin / "operator" / name).read_bytes())
    (mixed / "key.pem").chmod(0o600)
    for folder in (foreign / "operator", mixed):
        with pytest.raises(UnreachableError, match="of its CA"):
            open_client(lab.tls, folder, timeout_s=0.2)
    with pytest.raises(UnreachableError):
        open_client(lab.tls.replace("tls/localhost", "tcp/127.0.0.1"), timeout_s=0.2)


def test_a_router_without_the_robots_certificate_is_not_believed(lab: Lab, keys: Path) -> None:
    """Neither one that has a viewer's, nor the robot's own under a name that is not the robot's."""
    impostor = BusConfig(listen=(f"tls/localhost:{free_port()}",), keys=str(keys / "viewer"))
    with open_router(impostor), pytest.raises(UnreachableError):
        open_client(impostor.listen[0], keys / "operator", timeout_s=0.2)
    elsewhere = BusConfig(listen=(f"tls/127.0.0.2:{free_port()}",), keys=str(keys / "robot"))
    with open_router(elsewhere), pytest.raises(UnreachableError, match="the host's name"):
        open_client(elsewhere.listen[0], keys / "operator", timeout_s=0.2)


def test_a_laptop_finds_its_keys_where_they_usually_are(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    assert lab.keys is not None
    monkeypatch.setenv("EDGEFUSION_KEYS", str(lab.keys / "viewer"))
    with edgefusion.connect(lab.tls) as robot:
        assert robot.status.alive == frozenset()


def test_a_client_speaks_in_clear_text_to_its_own_computer_alone(keys: Path) -> None:
    with pytest.raises(RefusedError, match="tcp on loopback only, or tls"):
        open_client("tcp/192.168.0.5:7447")
    with pytest.raises(RefusedError, match="expected keys"):
        open_client("tls/192.168.0.5:7447")


def test_z9_by_default_the_router_listens_on_loopback_and_nowhere_else() -> None:
    with ExitStack() as stack:
        before = own_sockets()
        lab = Lab(stack)
        lab.router(), lab.member(), lab.client()
        port = int(lab.tcp.rsplit(":", 1)[1])
        opened = [each for each in own_sockets() if each not in before]
        assert {each.port for each in opened if each.listens} == {port}
        assert all(each.protocol == "tcp" and each.is_loopback for each in opened)


def test_what_is_larger_than_any_command_ends_at_the_router(lab: Lab) -> None:
    heard, operator = Sink(lab.member(), "robot/**"), lab.client("operator")
    until(lambda: (operator.put("robot/cmd_vel", b"x"), heard.samples)[1])
    heard.samples.clear()
    operator.put("robot/goal_pose", b"x" * 100_000)
    until(lambda: (operator.put("robot/goal_pose", b"small"), b"small" in heard.payloads())[1])
    assert all(len(payload) < 10 for payload in heard.payloads())


def test_what_is_larger_than_any_message_is_not_even_put_together(lab: Lab) -> None:
    heard, robot = Sink(lab.member(), "robot/image/compressed"), lab.member()

    def put(size: int) -> bool:
        robot.put("robot/image/compressed", b"x" * size, congestion_control=zenoh.CongestionControl.BLOCK)
        return size in map(len, heard.payloads())

    until(lambda: put(6_000_000))
    put(9_000_000)
    until(lambda: put(1000))
    assert 9_000_000 not in map(len, heard.payloads())


def test_of_commands_that_come_at_once_the_last_one_counts(lab: Lab) -> None:
    inbox = Inbox(lab.member(), "robot", CMD_VEL, to_cmd_vel, Freshness(LIMITS))
    publisher = CommandPublisher(lab.client("operator"), "robot", CMD_VEL, Tagger(), 5000)
    until(lambda: publisher.heard)
    for _ in range(20):
        for x_mps in (0.3, 0.2, 0.0):  # a key is let go
            publisher.put(Twist(Vector3(x=x_mps)))
        until(lambda: inbox.waiting == 3)
        assert [twist.v_mps for _, twist in inbox.take(time.monotonic_ns())] == [0.3, 0.2, 0.0]


def test_of_more_commands_than_may_come_at_once_the_last_one_counts(lab: Lab) -> None:
    """As they come when a network that was held up goes on."""
    robot, taken = lab.member(), []
    inbox = Inbox(robot, "robot", CMD_VEL, to_cmd_vel, Freshness(CommandLimits(4096, 50.0)))
    heard, publisher = (
        Sink(robot, "robot/cmd_vel"),
        CommandPublisher(lab.client("operator"), "robot", CMD_VEL, Tagger(), 60_000),
    )
    until(lambda: publisher.heard)
    for x_mps in (*(0.3 for _ in range(12)), 0.0):
        publisher.put(Twist(Vector3(x=x_mps)))
    until(lambda: encode(Twist()) in heard.payloads())
    until(lambda: (taken.extend(inbox.take(time.monotonic_ns())), taken and taken[-1][1] == Twist2D())[1])
