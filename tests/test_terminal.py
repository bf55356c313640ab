# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Lines that are drawn in place stay within the terminal, however small it is."""

from __future__ import annotations

import fcntl
import os
import pty
import struct
import termios
from typing import Iterator, Tuple

import pytest

from edgefusion.tools.terminal import Screen


@pytest.fixture
def terminal() -> Iterator[Tuple[int, int]]:
    """One of 4 rows and 10 columns: where it is looked at, and where it is written to."""
    outside, inside = pty.openpty()
    fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", 4, 10, 0, 0))
    yield outside, inside
    os.close(outside), os.close(inside)


def test_of_more_lines_than_there_are_rows_the_last_are_shown_and_overwritten(terminal: Tuple[int, int]) -> None:
    outside, inside = terminal
    with os.fdopen(os.dup(inside), "w") as out:
        screen = Screen(out)
        screen.show([f"line {i} and more" for i in range(9)])
        first = os.read(outside, 4096).decode()
        screen.show(["last"])
        second = os.read(outside, 4096).decode()
    assert [text[:10] for text in first.split("\x1b[2K")[1:]] == ["line 6 and", "line 7 and", "line 8 and"]
    assert second.startswith("\x1b[3A\x1b[2Klast")
