# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The bus is closed by default, and a configuration that would open it to everybody is refused."""

from __future__ import annotations

from typing import Any, Dict

import pytest

from edgefusion.config.bus import BusConfig
from edgefusion.config.endpoint import Endpoint, parse_endpoint
from edgefusion.errors import RefusedError


def test_by_default_only_this_computer_is_let_in() -> None:
    (listen,) = BusConfig().listen
    assert parse_endpoint("listen", listen).is_loopback


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"listen": ("tcp/0.0.0.0:7447",)}, "tcp on loopback only, or tls with keys, got tcp/0.0.0.0:7447"),
        ({"listen": ("tcp/[::]:7447",)}, "tcp on loopback only"),
        ({"listen": ("tcp/192.168.0.5:7447",)}, "tcp on loopback only"),
        ({"listen": ("tcp/robot.local:7447",)}, "tcp on loopback only"),
        ({"listen": ("tcp/127.0.0.1:7447", "tcp/0.0.0.0:7448"), "keys": "k"}, "tcp on loopback only"),
        ({"listen": ("tls/0.0.0.0:7447",)}, "expected keys for tls/0.0.0.0:7447"),
        ({"listen": ("tls/0.0.0.0:7447", "tcp/127.0.0.1:7447"), "keys": "k"}, "a different port for each"),
        ({"listen": ()}, "listen"),
        ({"listen": ("udp/127.0.0.1:7447",)}, "expected tcp/HOST:PORT or tls/HOST:PORT"),
        ({"listen": ("tcp/127.0.0.1:0",)}, "expected tcp/HOST:PORT"),
        ({"listen": ("tcp/127.0.0.1:65536",)}, "expected tcp/HOST:PORT"),
        ({"listen": ("tcp/127.0.0.1:7447#iface=eth0",)}, "expected tcp/HOST:PORT"),
        ({"connect": "tcp/192.168.0.5:7447"}, "connect: expected tcp on loopback only"),
        ({"connect": "tls/192.168.0.5:7447"}, "connect: expected keys"),
        ({"robot": "a/b"}, "robot"),
        ({"robot": "*"}, "robot"),
        ({"robot": ""}, "robot"),
        ({"robot": "@"}, "robot"),
        ({"jpeg_quality": 0}, "jpeg_quality"),
        ({"lease_s": 0.0}, "lease_s"),
    ],
)
def test_what_would_open_it_or_makes_no_sense_is_refused(settings: Dict[str, Any], reason: str) -> None:
    with pytest.raises(RefusedError, match=reason):
        BusConfig(**settings)


@pytest.mark.parametrize(
    ("settings", "router"),
    [
        ({}, "tcp/127.0.0.1:7447"),
        ({"listen": ("tls/0.0.0.0:7447",), "keys": "k"}, "tls/localhost:7447"),
        ({"listen": ("tls/0.0.0.0:7447", "tcp/localhost:7446"), "keys": "k"}, "tcp/localhost:7446"),
        ({"listen": ("tls/[::]:7447",), "keys": "k"}, "tls/localhost:7447"),
        ({"listen": ("tls/192.168.0.5:7447",), "keys": "k"}, "tls/192.168.0.5:7447"),
        ({"connect": "tls/robot:7447", "keys": "k"}, "tls/robot:7447"),
    ],
)
def test_the_robots_own_processes_find_the_router_by_loopback_where_they_can(
    settings: Dict[str, Any], router: str
) -> None:
    assert BusConfig(**settings).router == router


@pytest.mark.parametrize(
    ("text", "loopback"),
    [
        ("tcp/127.0.0.1:7447", True),
        ("tcp/127.8.8.8:1", True),
        ("tcp/[::1]:7447", True),
        ("tcp/localhost:7447", True),
        ("tcp/0.0.0.0:7447", False),
        ("tcp/localhost.example.org:7447", False),
        ("tls/robot:65535", False),
    ],
)
def test_an_endpoint_knows_whether_it_is_loopback(text: str, loopback: bool) -> None:
    endpoint = parse_endpoint("listen", text)
    assert (str(endpoint), endpoint.is_loopback) == (text, loopback)
    assert endpoint == Endpoint(endpoint.protocol, endpoint.host, endpoint.port)
