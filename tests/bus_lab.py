# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Real sessions on loopback for tests, on ports that were free a moment ago; all are closed at the end."""

from __future__ import annotations

import socket
import time
from contextlib import ExitStack
from datetime import datetime
from pathlib import Path
from typing import Callable, List, Optional

import zenoh

from edgefusion.bus import key_folder
from edgefusion.bus.router import open_router
from edgefusion.bus.session import open_client, open_member
from edgefusion.config.bus import BusConfig

SOON_S = 30.0
"""So long a test waits for what usually takes milliseconds, or a start of Python: a machine may be busy."""

QUIET_S = 0.2
"""So long it waits for what must not come."""


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def make_keys(folder: Path) -> Path:
    key_folder.init(folder, ["robot"], datetime(2040, 1, 1))
    return folder


def until(condition: Callable[[], object], timeout_s: float = SOON_S) -> None:
    """Waits for a condition; an assertion fails where it does not come true."""
    end_s = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < end_s, "waited in vain"
        time.sleep(0.005)


def wait_for_listener(session: zenoh.Session, key: str) -> None:
    """Until what this session puts there has somebody to hear it."""
    publisher = session.declare_publisher(key)
    until(lambda: publisher.matching_status.matching)
    publisher.undeclare()


class Lab:
    """A router, and who is on it. keys: a folder of `edgefusion keys init`; then it also listens by TLS."""

    def __init__(self, stack: ExitStack, keys: Optional[Path] = None, **settings: object) -> None:
        self._stack, self.keys = stack, keys
        self.tcp = f"tcp/127.0.0.1:{free_port()}"
        self.tls = f"tls/localhost:{free_port()}"
        listen = (self.tcp,) if keys is None else (self.tcp, self.tls)
        folder = None if keys is None else str(keys / "robot")
        self.config = BusConfig(listen=listen, keys=folder, **settings)

    def router(self) -> zenoh.Session:
        return self.keep(open_router(self.config))

    def member(self) -> zenoh.Session:
        """One of the robot's own processes; it is connected when it is given."""
        session = self.keep(open_member(self.config))
        until(lambda: list(session.info.routers_zid()))
        return session

    def client(self, role: Optional[str] = None) -> zenoh.Session:
        """By TLS with the keys of a role, or by loopback."""
        if role is None:
            return self.keep(open_client(self.tcp))
        assert self.keys is not None
        return self.keep(open_client(self.tls, self.keys / role))

    def keep(self, session: zenoh.Session) -> zenoh.Session:
        self._stack.callback(session.close)
        return session


class Sink:
    """What came on a key."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self.samples: List[zenoh.Sample] = []
        self._subscriber = session.declare_subscriber(key, self.samples.append)

    def payloads(self) -> List[bytes]:
        return [sample.payload.to_bytes() for sample in self.samples]
