# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A thread that tells others what a loop did: the loop hands it over and never waits for who listens."""

from __future__ import annotations

import logging
import threading
from collections import deque
from typing import Callable, Deque, Generic, TypeVar

from edgefusion.waiting import Wake, join

T = TypeVar("T")

MOST_WAITING = 64
"""Of a loop at 20 Hz and a laser at 37.5 Hz that is a second; then the oldest are lost."""

TURN_S = 0.5

log = logging.getLogger(__name__)


class Teller(Generic[T]):
    """tell: is called in the thread, with each in its order; what it raises is logged once, and costs that one alone.

    failures: how often that was. lost: how many came while too many waited.
    """

    def __init__(self, name: str, tell: Callable[[T], None]) -> None:
        self._name, self._tell = name, tell
        self._waiting: Deque[T] = deque(maxlen=MOST_WAITING)
        self._wake, self._ending = Wake(), False
        self.failures = self.lost = 0
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def __call__(self, what: T) -> None:
        """From any thread; never waits."""
        self.lost += len(self._waiting) == MOST_WAITING
        self._waiting.append(what)
        self._wake()

    def begin(self) -> None:
        """Starts the thread."""
        self._thread.start()

    def end(self, timeout_s: float) -> bool:
        """Whether it has told what was waiting and ended by then."""
        self._ending = True
        self._wake()
        return join(self._thread, timeout_s)

    def _run(self) -> None:
        while not (self._ending and not self._waiting):
            if not self._waiting:
                self._wake.wait(TURN_S)
            while self._waiting:
                self._try(self._waiting.popleft())

    def _try(self, what: T) -> None:
        try:
            self._tell(what)
        except Exception:
            self.failures += 1
            if self.failures == 1:
                log.exception("%s: cannot be told; further failures are only counted", self._name)
