# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Signals as bytes of a pipe: a loop that waits for other things, too, sees them between two of its turns."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, Sequence, Type

ENDS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""What asks a program to end. One that is ignored stays so, as SIGHUP under nohup."""

_NONE = b"\0"


class SignalPipe:
    """Within it, and in the main thread alone. fileno(): readable when something came."""

    def __init__(self) -> None:
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        os.set_blocking(self._writer, False)
        self._before: dict[int, Any] = {}
        self._before_fd = -1

    def __enter__(self) -> SignalPipe:
        self._before_fd = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        for number in (*ENDS, signal.SIGCHLD):
            if number == signal.SIGCHLD or signal.getsignal(number) is not signal.SIG_IGN:
                self._before[number] = signal.signal(number, _seen)
        return self

    def __exit__(self, _: Type[BaseException] | None, __: BaseException | None, ___: TracebackType | None) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._before_fd)
        writer, self._writer = self._writer, -1
        os.close(writer)
        os.close(self._reader)

    def fileno(self) -> int:
        return self._reader

    def wake(self) -> None:
        """Makes it readable, from any thread; no signal comes of that. Nothing once it was left."""
        with suppress(OSError):
            os.write(self._writer, _NONE)

    def take(self) -> Sequence[signal.Signals]:
        """The signals that came since the last time; never waits."""
        with suppress(BlockingIOError):
            return [signal.Signals(number) for number in os.read(self._reader, 4096) if number]
        return []


def _seen(_: int, __: FrameType | None) -> None:
    """The pipe has it."""
