# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the doctor says of the bus: closed by default, and told where it is not (Z9 of the fault figures)."""

from __future__ import annotations

import socket
import time
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from doctor_scenes import examination, told
from edgefusion.tools.doctor_bus import check_bus, exposures
from edgefusion.tools.doctor_finding import Finding
from edgefusion.tools.doctor_sockets import Socket, own_sockets

zenoh = pytest.importorskip("zenoh")
key_folder = pytest.importorskip("edgefusion.bus.key_folder")

YEAR_S = 366 * 86400


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def found(folder: Path, open_router: Any = None, **bus: Any) -> list[Finding]:
    return list(check_bus(examination(folder, bus=bus, service={"processes": ("bus",)}), open_router))


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    """The folders of all roles, good for a year."""
    key_folder.init(tmp_path / "keys", ["127.0.0.1"], datetime(1970, 1, 1) + timedelta(seconds=time.time() + YEAR_S))
    return tmp_path / "keys"


def test_the_usual_bus_has_no_multicast_and_listens_on_loopback_only(tmp_path: Path) -> None:
    port = free_port()
    (finding,) = found(tmp_path, listen=(f"tcp/127.0.0.1:{port}",))
    assert told([finding]) == ["ok bus"]
    assert finding.text.startswith(f"listens on tcp/127.0.0.1:{port}, no multicast; only programs of this computer")


def test_a_router_as_zenoh_opens_it_by_itself_fails_for_its_multicast_and_its_open_listener(tmp_path: Path) -> None:
    findings = found(tmp_path, lambda _: zenoh.open(zenoh.Config()), listen=(f"tcp/127.0.0.1:{free_port()}",))
    assert set(told(findings)) == {"failed bus"}
    assert any("by UDP, on 224.0.0.224:7446" in each.text for each in findings)
    assert any("it listens without TLS on " in each.text for each in findings)


@pytest.mark.parametrize(
    ("opened", "text"),
    [
        (Socket("tcp", "127.0.0.1", 7447, True), ""),
        (Socket("tcp", "::1", 7447, True), ""),
        (Socket("tcp", "0.0.0.0", 8447, True), ""),
        (Socket("tcp", "0.0.0.0", 7447, True), "listens without TLS on 0.0.0.0:7447"),
        (Socket("tcp", "::", 7447, True), "listens without TLS on :::7447"),
        (Socket("tcp", "192.168.0.5", 7447, True), "listens without TLS on 192.168.0.5:7447"),
        (Socket("tcp", "192.168.0.5", 7447, False), ""),
        (Socket("udp", "0.0.0.0", 40000, False), "looks for others by UDP"),
    ],
)
def test_only_loopback_and_tls_are_no_exposure(opened: Socket, text: str) -> None:
    found = exposures([opened], ["tcp/127.0.0.1:7447", "tls/0.0.0.0:8447"])
    assert len(found) == (1 if text else 0)
    assert all(text in each for each in found)


@pytest.mark.parametrize(
    ("family", "kind", "address", "protocol"),
    [
        (socket.AF_INET, socket.SOCK_STREAM, "127.0.0.1", "tcp"),
        (socket.AF_INET, socket.SOCK_STREAM, "0.0.0.0", "tcp"),
        (socket.AF_INET6, socket.SOCK_STREAM, "::1", "tcp"),
        (socket.AF_INET, socket.SOCK_DGRAM, "0.0.0.0", "udp"),
    ],
)
def test_the_sockets_of_this_process_are_seen_as_they_are(family: Any, kind: Any, address: str, protocol: str) -> None:
    try:
        opened = socket.socket(family, kind)
        opened.bind((address, 0))
    except OSError as error:
        pytest.skip(f"no such address here: {error}")
    with opened:
        if protocol == "tcp":
            opened.listen()
        expected = Socket(protocol, address, opened.getsockname()[1], protocol == "tcp")
        assert expected in own_sockets()
        assert expected.is_loopback == (address in ("127.0.0.1", "::1"))
    assert expected not in own_sockets()


def test_a_port_that_is_taken_is_told_without_the_librarys_words(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        (finding,) = found(tmp_path, listen=(endpoint,))
    assert told([finding]) == ["failed bus"]
    assert finding.text == f"cannot listen on {endpoint}"
    assert "systemctl stop" in finding.cure


def test_keys_are_told_with_their_end_after_a_handshake_with_the_router(tmp_path: Path, keys: Path) -> None:
    endpoint = f"tls/0.0.0.0:{free_port()}"
    exam = examination(tmp_path, bus={"listen": (endpoint,), "keys": str(keys / "robot")})
    (finding,) = check_bus(exam)
    assert told([finding]) == ["ok bus"]
    assert f"listens on {endpoint}, no multicast; its keys are good until 20" in finding.text
    late_s = time.time() + YEAR_S - 10 * 86400
    (finding,) = check_bus(exam, now=lambda: late_s)
    assert told([finding]) == ["warning bus"]
    assert "these keys end on 20" in finding.text


@pytest.mark.parametrize("role", ["operator", "viewer"])
def test_keys_of_another_role_are_not_a_robots(tmp_path: Path, keys: Path, role: str) -> None:
    findings = found(tmp_path, listen=(f"tls/127.0.0.1:{free_port()}",), keys=str(keys / role))
    assert told(findings) == ["failed bus"]


def test_keys_that_others_can_read_or_that_are_missing_are_refused(tmp_path: Path, keys: Path) -> None:
    (keys / "robot" / "key.pem").chmod(0o644)
    endpoint = f"tls/127.0.0.1:{free_port()}"
    for folder, text in ((keys / "robot", "only its owner can read"), (tmp_path / "none", "expected a readable file")):
        (finding,) = found(tmp_path, listen=(endpoint,), keys=str(folder))
        assert told([finding]) == ["failed bus"]
        assert text in finding.text


def test_a_machine_without_the_router_asks_for_it(tmp_path: Path) -> None:
    port = free_port()
    exam = examination(tmp_path, bus={"connect": f"tcp/127.0.0.1:{port}"}, service={"processes": ("base",)})
    (finding,) = check_bus(exam, connect_s=0.3)
    assert told([finding]) == ["failed bus"]
    assert "no router let us in" in finding.text
    from edgefusion.bus.router import open_router

    router = open_router(examination(tmp_path, bus={"listen": (f"tcp/127.0.0.1:{port}",)}).config.bus)
    try:
        (finding,) = check_bus(exam)
        assert told([finding]) == ["ok bus"]
    finally:
        router.close()


def test_a_machine_without_the_router_is_told_when_its_keys_are_not_a_robots(tmp_path: Path, keys: Path) -> None:
    from edgefusion.bus.router import open_router

    endpoint = f"tls/127.0.0.1:{free_port()}"
    bus = {"listen": (endpoint,), "keys": str(keys / "robot")}
    router = open_router(examination(tmp_path, bus=bus).config.bus)
    said = []
    try:
        for role in ("robot", "operator", "viewer"):
            bus = {"connect": endpoint, "keys": str(keys / role)}
            (finding,) = check_bus(examination(tmp_path, bus=bus, service={"processes": ("base",)}))
            said.append((finding.state.value, "expected a robot's keys, got " + role in finding.text))
    finally:
        router.close()
    assert said == [("ok", False), ("failed", True), ("failed", True)]


def test_keys_are_of_no_account_to_a_machine_that_reaches_the_router_on_loopback(tmp_path: Path, keys: Path) -> None:
    from edgefusion.bus.router import open_router

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    router = open_router(examination(tmp_path, bus={"listen": (endpoint,)}).config.bus)
    try:
        bus = {"connect": endpoint, "keys": str(keys / "viewer")}
        assert told(check_bus(examination(tmp_path, bus=bus, service={"processes": ("base",)}))) == ["ok bus"]
    finally:
        router.close()
