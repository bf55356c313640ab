# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Logs on standard error: plain lines for people, lines with a priority for systemd's journal; and never a flood."""

from __future__ import annotations

import logging
import os
import sys
from collections import OrderedDict
from typing import Mapping, TextIO, Tuple

from edgefusion.clock import Clock, system_clock
from edgefusion.service.log_writer import LogWriter

BURST = 5
"""So many like each other are told ..."""

WINDOW_NS = 10_000_000_000
"""... within so long. The next one after that says how many were not."""

_KINDS = 1000
"""So many that are not like each other are told apart."""
_PRIORITIES = ((logging.CRITICAL, 2), (logging.ERROR, 3), (logging.WARNING, 4), (logging.INFO, 6))
_DEBUG = 7


class Quiet(logging.Filter):
    """Lets pass only so many that are like each other: said at the same place of the program, at the same level, and of
    the same thing, the first of its values where that is a name."""

    def __init__(self, burst: int = BURST, window_ns: int = WINDOW_NS, clock: Clock = system_clock) -> None:
        super().__init__()
        self._burst, self._window_ns, self._clock = burst, window_ns, clock
        self._seen: OrderedDict[Tuple[str, int, int, str], Tuple[int, int]] = OrderedDict()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether it is to be told; adds to it how many before it were not."""
        key, now_ns = (record.pathname, record.lineno, record.levelno, _thing(record)), self._clock()
        begun_ns, count = self._seen.pop(key, (now_ns, 0))
        if now_ns - begun_ns > self._window_ns:
            if count > self._burst:
                record.msg, record.args = f"{record.getMessage()} (and {count - self._burst} more like it before)", ()
            begun_ns, count = now_ns, 0
        self._seen[key] = begun_ns, count + 1
        if len(self._seen) > _KINDS:
            self._seen.popitem(last=False)
        return count < self._burst


def _thing(record: logging.LogRecord) -> str:
    first = record.args[0] if isinstance(record.args, tuple) and record.args else ""
    return first if isinstance(first, str) else ""


class PlainFormatter(logging.Formatter):
    """With the time of day, and the process: `12:00:00.250 base: warning: laser: nothing came`."""

    def __init__(self, process: str) -> None:
        super().__init__(f"%(asctime)s.%(msecs)03d {process}: %(message)s", "%H:%M:%S")

    def formatMessage(self, record: logging.LogRecord) -> str:
        """A level that is not the usual one is named."""
        if record.levelno != logging.INFO:
            record.message = f"{record.levelname.lower()}: {record.message}"
        return super().formatMessage(record)


class JournalFormatter(logging.Formatter):
    """Each line with its priority, by which `journalctl -p` picks; the journal adds the time."""

    def __init__(self, process: str) -> None:
        super().__init__(f"{process}: %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        priority = next((number for level, number in _PRIORITIES if record.levelno >= level), _DEBUG)
        return "\n".join(f"<{priority}>{line}" for line in super().format(record).splitlines())


def set_up_logs(
    process: str,
    level: str = "info",
    stream: TextIO | None = None,
    environment: Mapping[str, str] | None = None,
    clock: Clock = system_clock,
) -> None:
    """All logs of this process go to the stream, standard error by default, and nobody who logs waits for that.

    process: its name in them. level: debug, info, warning or error.
    """
    stream = sys.stderr if stream is None else stream
    journal = is_journal(stream, os.environ if environment is None else environment)
    handler = LogWriter(stream)
    handler.setFormatter(JournalFormatter(process) if journal else PlainFormatter(process))
    handler.addFilter(Quiet(clock=clock))
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)


def is_journal(stream: TextIO, environment: Mapping[str, str]) -> bool:
    """Whether systemd's journal reads the stream: it says in JOURNAL_STREAM which device and file that is."""
    try:
        status = os.fstat(stream.fileno())
    except (OSError, ValueError):  # no file at all
        return False
    return environment.get("JOURNAL_STREAM") == f"{status.st_dev}:{status.st_ino}"
