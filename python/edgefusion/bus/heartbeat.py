# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""An operator's sign of life, ten times a second, from a thread: it stops when the process does."""

from __future__ import annotations

import threading
from types import TracebackType
from typing import Optional, Type

import zenoh

from edgefusion.bus.publisher import CommandPublisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import HEARTBEAT
from edgefusion.messages.std_msgs import String
from edgefusion.waiting import Wake

PERIOD_S = 0.1
TTL_MS = 300


class Heartbeat:
    """Beats within its `with`."""

    def __init__(self, session: zenoh.Session, robot: str, tagger: Tagger) -> None:
        self._publisher = CommandPublisher(session, robot, HEARTBEAT, tagger, TTL_MS)
        self._ending, self._wake = False, Wake()
        self._thread = threading.Thread(target=self._beat, name="heartbeat")

    def __enter__(self) -> Heartbeat:
        self._thread.start()
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self._ending = True
        self._wake()
        self._thread.join()
        self._publisher.undeclare()

    def _beat(self) -> None:
        while not self._ending:
            self._publisher.put(String())
            self._wake.wait(PERIOD_S)
