# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Signals as an exception, as Ctrl-C is one: what must be done at the end is done wherever the program is."""

from __future__ import annotations

import signal
import sys
from contextlib import contextmanager
from typing import Any, Iterator, NoReturn

_ENDS = (signal.SIGTERM, signal.SIGHUP)

_AGAIN_S = 0.01


@contextmanager
def ended_by_signals(exit_code: int = 0) -> Iterator[None]:
    """Within this, SIGTERM, and SIGHUP of a terminal that was closed, raise SystemExit in the main thread, once: what
    is done at the end is not disturbed by another. It is the usual end of a service, and no failure; whose exit code
    is an answer, and was not given it yet, ends with another.

    A signal that is ignored stays so, as SIGHUP under nohup. For the main thread alone.
    """
    numbers = [number for number in _ENDS if signal.getsignal(number) is not signal.SIG_IGN]
    ending = _Ending(exit_code, sys.unraisablehook)
    before = {number: signal.signal(number, ending.begin) for number in numbers}
    before[signal.SIGALRM] = signal.signal(signal.SIGALRM, ending.begin)
    sys.unraisablehook = ending.lost
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        sys.unraisablehook = ending.unraisable
        for number, handler in before.items():
            signal.signal(number, handler)


class _Ending:
    """The exception, until it has come through: Python drops one that is raised within a destructor or a callback of
    its own, as those of an import."""

    def __init__(self, exit_code: int, unraisable: Any) -> None:
        self._exit_code, self.unraisable = exit_code, unraisable
        self._raised: SystemExit | None = None

    def begin(self, *_: object) -> NoReturn:
        for number in _ENDS:
            signal.signal(number, signal.SIG_IGN)
        self._raised = SystemExit(self._exit_code)
        raise self._raised

    def lost(self, what: Any) -> None:
        if what.exc_value is self._raised and self._raised is not None:
            signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)  # not now: whoever dropped it is still at it
        else:
            self.unraisable(what)
