# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""SIGTERM as an exception, as Ctrl-C is one: what must be done at the end is done wherever the program is."""

from __future__ import annotations

import signal
from contextlib import contextmanager
from types import FrameType
from typing import Iterator


@contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """Within this, SIGTERM raises SystemExit in the main thread, once: what is done at the end is not disturbed by
    another. It is the usual end of a service, and no failure. For the main thread alone."""
    before = signal.signal(signal.SIGTERM, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _end(number: int, _: FrameType | None) -> None:
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit(0)
