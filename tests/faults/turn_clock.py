# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Threads in a time of their own: one runs at a time, and time goes on to when the next one's wait is over."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, Tuple

from edgefusion.clock import SimClock


class OverError(BaseException):
    """The test is over: a thread unwinds."""


class TurnClock(SimClock):
    """Whoever advances it waits for so long, and the others have their turns. Who waits for the same time goes on in
    the order in which they began to wait: what happens is the same each time.

    errors: what ended threads, by name.
    """

    def __init__(self, start_ns: int = 0) -> None:
        super().__init__(start_ns)
        self._waiting: Dict[str, Tuple[int, int]] = {}  # until when, and since which wait
        self._turns: Dict[str, threading.Semaphore] = {"": threading.Semaphore(0)}
        self._names = {threading.get_ident(): ""}
        self._waits, self._over = 0, False
        self.errors: Dict[str, Exception] = {}
        self._threads: Dict[str, threading.Thread] = {}

    def spawn(self, name: str, run: Callable[[], Any]) -> None:
        """A thread, whose first turn is due now."""
        self._turns[name] = threading.Semaphore(0)
        self._wait(name, 0)
        self._threads[name] = threading.Thread(target=self._run, args=(name, run), name=name, daemon=True)
        self._threads[name].start()

    def advance(self, ns: int) -> int:
        """Waits so long."""
        name = self._names.get(threading.get_ident())
        if self._over or name is None:
            return super().advance(ns)
        self._wait(name, ns)
        self._next(name)
        return self()

    def lasts(self, name: str) -> bool:
        """Whether that thread has not ended."""
        return self._threads[name].is_alive()

    def wake(self, name: str) -> None:
        """Its wait is over."""
        if name in self._waiting:
            self._wait(name, 0)

    def halt(self, ns: int, *names: str) -> None:
        """These, by default all but the test, have no turn for so long, whatever they wait for."""
        for name in names or tuple(name for name in self._waiting if name):
            until_ns, number = self._waiting[name]
            self._waiting[name] = max(until_ns, self() + ns), number

    def finish(self) -> None:
        """All threads unwind, at no time."""
        self._over = True
        for name in self._threads:
            self._turns[name].release()
        for thread in self._threads.values():
            thread.join()

    def _run(self, name: str, run: Callable[[], Any]) -> None:
        self._names[threading.get_ident()] = name
        self._turns[name].acquire()
        try:
            if not self._over:
                run()
        except OverError:
            pass
        except Exception as error:
            self.errors[name] = error
        if not self._over:
            self._waiting.pop(name, None)
            self._next(name, ends=True)

    def _wait(self, name: str, ns: int) -> None:
        self._waits += 1
        self._waiting[name] = self() + ns, self._waits

    def _next(self, name: str, ends: bool = False) -> None:
        """The turn goes to whose wait is over first."""
        first = min(self._waiting, key=lambda each: self._waiting[each])
        super().advance(max(0, self._waiting[first][0] - self()))
        if first == name:
            return
        self._turns[first].release()
        if not ends:
            self._turns[name].acquire()
            if self._over:
                raise OverError
