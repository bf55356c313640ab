# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Sessions of Zenoh that listen to nobody and look for nobody: they know the router's endpoint, and only that.

All but the router are its clients, the robot's own processes, too: Zenoh routes nothing between two peers of a router
that do not find each other. A client that was let in once finds the router again after it was gone.
"""

from __future__ import annotations

import atexit
import json
from pathlib import Path
from types import MappingProxyType
from typing import Any, Mapping, Optional, Protocol

import zenoh

from edgefusion.bus.key_files import KeyFiles, find_keys
from edgefusion.config.bus import BusConfig, check_endpoint

RETRY = {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 1.5}

QUEUED: Mapping[str, int] = MappingProxyType({"real_time": 16, "data_high": 16, "data": 16, "background": 4})
"""So many packets wait for a line; Zenoh's usual 2 are full as soon as a busy computer is late by a millisecond. Of
images, which take some packets each, few wait: on a slow line they would be old when they come."""


MOST_BYTES = 8_000_000
"""Of one message, twice what a large JPEG takes: Zenoh would put together up to a gigabyte in memory, for a viewer too,
and ask whether he may say it afterwards."""


class Declared(Protocol):
    """A subscriber, publisher, queryable or token of Zenoh's."""

    def undeclare(self) -> object: ...


class Closable(Protocol):
    """A session of Zenoh's."""

    def close(self) -> object: ...


class UnreachableError(ConnectionError):
    """The bus, or who should answer on it, is not there; one line says what was tried and what to look at."""


def open_client(
    endpoint: str, keys: Optional[Path] = None, timeout_s: float = 5.0, lease_s: float = 1.0
) -> zenoh.Session:
    """A session with the router at tcp/HOST:PORT or tls/HOST:PORT; keys: the folder of this machine's, for tls.

    Raises RefusedError for an endpoint or keys that will not do, UnreachableError where no router lets it in in time.
    """
    check_endpoint("endpoint", endpoint, keys is not None)
    settings = {
        "mode": "client",
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": max(1, round(timeout_s * 1e3)),
        **common_settings(lease_s),
        **client_tls(None if keys is None else find_keys(keys)),
    }
    try:
        return open_session(settings)
    except zenoh.ZError as error:
        hint = "" if keys is None else f", and are the keys in {keys} of its CA and the host's name in its certificate"
        raise UnreachableError(
            f"{endpoint}: no router let us in within {timeout_s:g} s: is it running{hint}?"
        ) from error


def open_member(config: BusConfig, timeout_s: float = 5.0) -> zenoh.Session:
    """A session of one of the robot's own processes. Raises as open_client."""
    keys = None if config.keys is None else Path(config.keys)
    return open_client(config.router, keys, timeout_s, config.lease_s)


def common_settings(lease_s: float) -> dict[str, Any]:
    """Closed, and without shared memory, which a killed process would leave behind."""
    return {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "connect/retry": RETRY,
        "transport/link/tx/lease": round(lease_s * 1e3),
        **{f"transport/link/tx/queue/size/{priority}": packets for priority, packets in QUEUED.items()},
        "transport/shared_memory/enabled": False,
        "adminspace/enabled": False,
        "transport/link/rx/max_message_size": MOST_BYTES,
    }


def client_tls(keys: Optional[KeyFiles]) -> dict[str, Any]:
    """Both ends show certificates, and the router's must name the host that we wanted."""
    if keys is None:
        return {}
    return {
        "transport/link/tls": {
            "root_ca_certificate": str(keys.ca),
            "connect_certificate": str(keys.certificate),
            "connect_private_key": str(keys.key),
            "enable_mtls": True,
            "verify_name_on_connect": True,
        }
    }


def open_session(settings: Mapping[str, Any]) -> zenoh.Session:
    """A session with these settings and Zenoh's defaults for the rest. Raises zenoh.ZError.

    One that nobody has closed is closed when the program ends: else a callback might come into its ruins.
    """
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    session = zenoh.open(config)
    closable: Closable = session
    atexit.register(closable.close)
    return session
