# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which components are on the bus: each has a token, which goes when its session does, at once or after the lease."""

from __future__ import annotations

import threading
from typing import Callable

import zenoh

from edgefusion.bus.callbacks import Guarded
from edgefusion.bus.session import Declared
from edgefusion.bus.subscriber import nobody
from edgefusion.bus.topics import ALIVE, key_of


def declare_alive(session: zenoh.Session, robot: str, component: str) -> zenoh.LivelinessToken:
    """While the token is kept and the session is open, this component is alive."""
    return session.liveliness().declare_token(key_of(robot, f"{ALIVE}/{component}"))


class Alive:
    """Which components are alive, from when it is made on. wake: is called, in a thread of Zenoh's, on every change."""

    def __init__(self, session: zenoh.Session, robot: str, wake: Callable[[], None] = nobody) -> None:
        self._lock, self._wake = threading.Lock(), wake
        self._components: set[str] = set()
        guarded: Guarded[zenoh.Sample] = Guarded(key_of(robot, ALIVE), self._change)
        self._subscriber: Declared = session.liveliness().declare_subscriber(
            key_of(robot, f"{ALIVE}/*"), guarded.handler, history=True
        )

    @property
    def components(self) -> frozenset[str]:
        with self._lock:
            return frozenset(self._components)

    def undeclare(self) -> None:
        self._subscriber.undeclare()

    def _change(self, sample: zenoh.Sample) -> None:
        component = str(sample.key_expr).rsplit("/", 1)[-1]
        with self._lock:
            if sample.kind == zenoh.SampleKind.PUT:
                self._components.add(component)
            else:
                self._components.discard(component)
        self._wake()
