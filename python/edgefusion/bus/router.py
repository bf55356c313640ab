# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The robot's router, in a process of its own: it alone reads what comes from the network.

What is larger than any command has no business at the motors' process, and ends here. Nothing limits how fast
velocities and goals may come: of what comes at once, as after a hiccup of a radio, Zenoh would let through the first,
and the last is what counts; base keeps the newest, which costs it little (`bus/ring.py`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import zenoh

from edgefusion.bus.access import access_control
from edgefusion.bus.key_files import find_keys
from edgefusion.bus.session import common_settings, open_session
from edgefusion.bus.tags import MOST_BYTES
from edgefusion.bus.topics import COMMANDS, HEARTBEAT, QUERIES, key_of
from edgefusion.config.bus import BusConfig

HEARTBEATS_HZ = 100.0
"""Of what comes faster one is worth as much as all."""

QUERIES_HZ = 1000.0
"""What comes sooner after the one before is not answered, and asked again."""


def open_router(config: BusConfig) -> zenoh.Session:
    """The router; it routes until it is closed.

    Raises RefusedError for keys that will not do, OSError for an endpoint that cannot be listened on.
    """
    try:
        return open_session(router_settings(config))
    except zenoh.ZError as error:
        listen = ", ".join(config.listen)
        raise OSError(f"bus: cannot listen on {listen}: is another router there? {error}") from error


def router_settings(config: BusConfig) -> dict[str, Any]:
    """What the router is told, by the names of Zenoh's configuration. Raises RefusedError for keys that will not do."""
    settings = {
        **common_settings(config.lease_s),
        "mode": "router",
        "listen/endpoints": list(config.listen),
        "access_control": access_control(config.robot),
        "low_pass_filter": [_size_limit(config)],
        "downsampling": [_rate_limit(config)],
    }
    if config.keys is not None:
        keys = find_keys(Path(config.keys))
        settings["transport/link/tls"] = {
            "root_ca_certificate": str(keys.ca),
            "listen_certificate": str(keys.certificate),
            "listen_private_key": str(keys.key),
            "enable_mtls": True,
        }
    return settings


def _size_limit(config: BusConfig) -> dict[str, Any]:
    names = [*(topic.name for topic in COMMANDS), *QUERIES]
    return {
        "id": "command-size",
        "messages": ["put", "query"],
        "flows": ["ingress"],
        "key_exprs": [key_of(config.robot, name) for name in names],
        "size_limit": config.max_command_bytes + MOST_BYTES,
    }


def _rate_limit(config: BusConfig) -> dict[str, Any]:
    """For each key of each connection: one that floods with what is no stop leaves room for the stop of another."""
    rates = {HEARTBEAT.name: HEARTBEATS_HZ, **{name: QUERIES_HZ for name in QUERIES}}
    rules = [{"key_expr": key_of(config.robot, name), "freq": hz} for name, hz in rates.items()]
    return {"id": "rate", "messages": ["put", "query"], "flows": ["ingress"], "rules": rules}
