# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Logs on standard error: plain lines for people, lines with a priority for systemd's journal; and never a flood."""

from __future__ import annotations

import logging
import os
import sys
import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import List, Mapping, TextIO, Tuple

from edgefusion.clock import Clock, system_clock
from edgefusion.service.log_writer import LogWriter

BURST = 5
"""So many like each other are told ..."""

WINDOW_NS = 10_000_000_000
"""... within so long. Of the others the last is told then, or the next one after that says how many they were."""

_KINDS = 1000
"""So many that are not like each other are told apart."""
_PRIORITIES = ((logging.CRITICAL, 2), (logging.ERROR, 3), (logging.WARNING, 4), (logging.INFO, 6))
_DEBUG = 7


@dataclass
class _Flood:
    """last: the newest that was not told; None where all were."""

    begun_ns: int
    count: int = 0
    last: logging.LogRecord | None = None


class Quiet(logging.Filter):
    """Lets pass only so many that are like each other: said at the same place of the program, at the same level, and of
    the same thing, the first of its values where that is a name."""

    def __init__(self, burst: int = BURST, window_ns: int = WINDOW_NS, clock: Clock = system_clock) -> None:
        super().__init__()
        self._burst, self._window_ns, self._clock = burst, window_ns, clock
        self._seen: OrderedDict[Tuple[str, int, int, str], _Flood] = OrderedDict()
        self._lock = threading.RLock()  # a signal's exception, or its log, may come in the middle

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether it is to be told; adds to it how many before it were not."""
        key, now_ns = (record.pathname, record.lineno, record.levelno, _thing(record)), self._clock()
        with self._lock:
            flood = self._seen.pop(key, None) or _Flood(now_ns)
            if now_ns - flood.begun_ns > self._window_ns:
                if flood.last is not None:
                    _add(record, f"(and {flood.count - self._burst} more like it before)")
                flood = _Flood(now_ns)
            flood.count += 1
            flood.last = record if flood.count > self._burst else None
            self._seen[key] = flood
            if len(self._seen) > _KINDS:
                self._seen.popitem(last=False)
        return flood.last is None

    def over(self) -> List[logging.LogRecord]:
        """The last of each flood that is over, once: how it ended must not go unsaid. With how many were not told."""
        now_ns, over = self._clock(), []
        with self._lock:
            for key, flood in list(self._seen.items()):
                if now_ns - flood.begun_ns > self._window_ns and flood.last is not None:
                    over.append(_add(flood.last, f"(the last of {flood.count - self._burst} more like it)"))
                    del self._seen[key]
        return over


def _add(record: logging.LogRecord, text: str) -> logging.LogRecord:
    record.msg, record.args = f"{record.getMessage()} {text}", ()
    return record


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
    quiet = Quiet(clock=clock)
    handler = LogWriter(stream, quiet.over)
    handler.setFormatter(JournalFormatter(process) if journal else PlainFormatter(process))
    handler.addFilter(quiet)
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)


def is_journal(stream: TextIO, environment: Mapping[str, str]) -> bool:
    """Whether systemd's journal reads the stream: it says in JOURNAL_STREAM which device and file that is."""
    try:
        status = os.fstat(stream.fileno())
    except (OSError, ValueError):  # no file at all
        return False
    return environment.get("JOURNAL_STREAM") == f"{status.st_dev}:{status.st_ino}"
