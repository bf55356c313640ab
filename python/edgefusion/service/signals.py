# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Signals as an exception, as Ctrl-C is one: what must be done at the end is done wherever the program is."""

from __future__ import annotations

import signal
from contextlib import contextmanager
from typing import Iterator

_ENDS = (signal.SIGTERM, signal.SIGHUP)


@contextmanager
def ended_by_signals(exit_code: int = 0) -> Iterator[None]:
    """Within this, SIGTERM, and SIGHUP of a terminal that was closed, raise SystemExit in the main thread, once: what
    is done at the end is not disturbed by another. It is the usual end of a service, and no failure; whose exit code
    is an answer, and was not given it yet, ends with another.

    A signal that is ignored stays so, as SIGHUP under nohup. For the main thread alone.
    """
    before = {number: signal.getsignal(number) for number in _ENDS}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, lambda *_: _end(exit_code))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(exit_code: int) -> None:
    for number in _ENDS:
        signal.signal(number, signal.SIG_IGN)
    raise SystemExit(exit_code)
