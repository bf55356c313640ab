# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Logs: readable in a terminal, with priorities in the journal, and never a flood of the same."""

from __future__ import annotations

import io
import logging
import os
import re
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Callable, Iterator, TextIO

import pytest

from edgefusion.clock import SimClock
from edgefusion.service.log_writer import KEPT, LogWriter
from edgefusion.service.logs import BURST, WINDOW_NS, Quiet, is_journal, set_up_logs

_LOG = logging.getLogger("edgefusion.test")


@pytest.fixture(autouse=True)
def logs_as_before() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    root.handlers.clear()
    yield
    root.handlers[:] = handlers
    root.setLevel(level)


@pytest.fixture
def journal(tmp_path: Path) -> Iterator[tuple[TextIO, dict[str, str]]]:
    with (tmp_path / "journal").open("w+") as file:
        status = os.fstat(file.fileno())
        yield file, {"JOURNAL_STREAM": f"{status.st_dev}:{status.st_ino}"}


def written() -> None:
    """Waits until all that was logged is, for as long as the end of a program does."""
    logging.getLogger().handlers[0].flush()


def until(condition: Callable[[], bool]) -> None:
    end_s = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < end_s, "waited in vain"
        time.sleep(0.005)


def lines_of(file: TextIO) -> list[str]:
    written()
    file.seek(0)
    return file.read().splitlines()


def test_in_a_terminal_a_line_has_the_time_the_process_and_a_level_that_is_not_the_usual() -> None:
    out = io.StringIO()
    set_up_logs("base", "debug", out, {})
    _LOG.debug("starts")
    _LOG.info("drives to %s", (5.0, 5.5))
    _LOG.warning("laser: %s", "nothing came")
    written()
    said = [re.sub(r"^\d\d:\d\d:\d\d\.\d\d\d ", "TIME ", line) for line in out.getvalue().splitlines()]
    assert said == [
        "TIME base: debug: starts",
        "TIME base: drives to (5.0, 5.5)",
        "TIME base: warning: laser: nothing came",
    ]


def test_the_journal_gets_a_priority_on_each_line(journal: tuple[TextIO, dict[str, str]]) -> None:
    file, environment = journal
    set_up_logs("base", "debug", file, environment)
    for level in (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR, logging.CRITICAL):
        _LOG.log(level, "%s", level)
    assert lines_of(file) == ["<7>base: 10", "<6>base: 20", "<4>base: 30", "<3>base: 40", "<2>base: 50"]


def test_a_traceback_in_the_journal_has_the_priority_of_its_message(journal: tuple[TextIO, dict[str, str]]) -> None:
    file, environment = journal
    set_up_logs("base", "info", file, environment)
    try:
        raise RuntimeError("a defect")
    except RuntimeError:
        _LOG.exception("laser: broke")
    lines = lines_of(file)
    assert lines[0] == "<3>base: laser: broke" and lines[-1] == "<3>RuntimeError: a defect"
    assert all(line.startswith("<3>") for line in lines) and len(lines) > 3


def test_what_is_below_the_level_is_not_told_and_a_second_call_replaces_the_first() -> None:
    first, second = io.StringIO(), io.StringIO()
    set_up_logs("base", "info", first, {})
    set_up_logs("base", "warning", second, {})
    _LOG.info("not told")
    _LOG.warning("told")
    written()
    assert first.getvalue() == "" and second.getvalue().count("told") == 1


def test_a_stream_is_the_journal_only_where_systemd_says_that_of_this_very_file(
    journal: tuple[TextIO, dict[str, str]],
) -> None:
    file, environment = journal
    assert is_journal(file, environment)
    assert not is_journal(file, {}) and not is_journal(file, {"JOURNAL_STREAM": "1:2"})
    assert not is_journal(io.StringIO(), environment)


def told_of(out: io.StringIO) -> list[str]:
    """What was told since the last time."""
    written()
    lines = [line.split(": ", 1)[1] for line in out.getvalue().splitlines()]
    out.seek(0)
    out.truncate()
    return lines


def complain(thing: str, times: int) -> None:
    for number in range(times):
        _LOG.info("%s: %d", thing, number)


def quiet_logs(clock: SimClock) -> tuple[io.StringIO, Quiet]:
    """Without a thread that tells late what was not told."""
    out, quiet = io.StringIO(), Quiet(clock=clock)
    handler = logging.StreamHandler(out)
    handler.setFormatter(logging.Formatter("base: %(message)s"))
    handler.addFilter(quiet)
    logging.basicConfig(level="INFO", handlers=[handler], force=True)
    return out, quiet


def test_a_flood_is_cut_and_the_next_one_says_how_much_was() -> None:
    clock = SimClock(1)
    out, _ = quiet_logs(clock)
    complain("laser", 100)
    assert told_of(out) == [f"laser: {number}" for number in range(BURST)]
    clock.advance(WINDOW_NS + 1)
    complain("laser", 2)
    assert told_of(out) == [f"laser: 0 (and {100 - BURST} more like it before)", "laser: 1"]
    clock.advance(WINDOW_NS + 1)
    complain("laser", 1)
    assert told_of(out) == ["laser: 0"]


def test_how_a_flood_ended_is_told_once_when_it_is_over() -> None:
    clock = SimClock(1)
    _, quiet = quiet_logs(clock)
    complain("laser", 100)
    complain("robot", BURST)
    assert quiet.over() == []
    clock.advance(WINDOW_NS + 1)
    assert [record.getMessage() for record in quiet.over()] == [f"laser: 99 (the last of {100 - BURST} more like it)"]
    assert quiet.over() == []


def test_what_is_told_late_is_told_though_nobody_says_it_then() -> None:
    late = [logging.makeLogRecord({"msg": "how it ended"})]
    out = io.StringIO()
    handler = LogWriter(out, lambda: [late.pop()] if late else [])
    handler.setFormatter(logging.Formatter("%(message)s"))
    logging.basicConfig(level="INFO", handlers=[handler], force=True)
    _LOG.info("how it began")
    until(lambda: not late)
    handler.close()
    written()
    assert out.getvalue() == "how it began\nhow it ended\n"


def test_the_flood_of_one_thing_does_not_hide_another() -> None:
    out, _ = quiet_logs(SimClock(1))
    complain("laser", 100)
    complain("robot", 1)
    _LOG.info("something else")
    assert told_of(out)[BURST:] == ["robot: 0", "something else"]


def test_the_memory_for_floods_is_bounded() -> None:
    out, quiet = quiet_logs(SimClock(1))
    for thing in range(3000):
        complain(f"thing {thing}", 1)
    assert len(quiet._seen) <= 1000
    assert len(told_of(out)) == 3000


@contextmanager
def unread() -> Iterator[tuple[TextIO, int]]:
    """A pipe that is full, as a terminal is that was halted by Ctrl-S; its ends."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writer, b"." * 4096)
    os.set_blocking(writer, True)
    with os.fdopen(writer, "w") as stream:
        yield stream, reader
    os.close(reader)


def read_up_to(reader: int, end: str) -> str:
    text = ""
    while not text.endswith(end):
        text += os.read(reader, 65536).decode()
    return text.lstrip(".")


def test_who_logs_does_not_wait_for_who_reads_and_is_read_later() -> None:
    with unread() as (stream, reader):
        set_up_logs("base", "info", stream, {})
        loop = threading.Thread(target=complain, args=("laser", BURST), daemon=True)
        loop.start()
        loop.join(30)
        stuck = loop.is_alive()
        told = read_up_to(reader, f"laser: {BURST - 1}\n")
    assert not stuck
    assert len(told.splitlines()) == BURST


def test_what_nobody_read_is_bounded_and_told_when_somebody_does() -> None:
    with unread() as (stream, reader):
        set_up_logs("base", "info", stream, {})
        for thing in range(KEPT + 7):
            complain(f"thing {thing}", 1)
        told = read_up_to(reader, f"thing {KEPT - 1}: 0\n")
        written()
        complain("the next", 1)
        assert read_up_to(reader, "\n").endswith("the next: 0 (7 lines before it are lost: nobody read them)\n")
    assert len(told.splitlines()) == KEPT


def test_a_program_ends_though_nobody_reads_its_log() -> None:
    code = (
        "import logging; from edgefusion.service.logs import set_up_logs; "
        "set_up_logs('base'); logging.error('the last word'); print('ends', flush=True)"
    )
    with unread() as (stream, _):
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=stream, timeout=60)
    assert (done.returncode, done.stdout) == (0, b"ends\n")
