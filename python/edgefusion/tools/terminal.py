# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A terminal that shows lines in place and hands over keys as they are pressed."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from contextlib import contextmanager
from typing import Iterator, Sequence, TextIO, Tuple

_UP, _CLEAR_LINE, _CLEAR_BELOW = "\x1b[{}A", "\x1b[2K", "\x1b[J"
_HIDE, _SHOW = "\x1b[?25l", "\x1b[?25h"
_KEYS = 4096
"""A terminal keeps no more."""
_INPUT, _KEYS_AT = 0, 6
"""In what termios tells of a terminal."""
_NO_KEY = b"\0"
_USUAL = (80, 24)


class Screen:
    """Lines that each new set of them overwrites."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._shown = 0

    def show(self, lines: Sequence[str]) -> None:
        """In place of what was shown before; cut at the right edge and, of more lines than there are rows, at the top:
        what wraps or has scrolled away could not be overwritten."""
        width, height = _size(self._out)
        lines = lines[-(height - 1) :] if height > 1 else ()
        up = _UP.format(self._shown) if self._shown else ""
        self._out.write(up + "".join(f"{_CLEAR_LINE}{line[:width]}\n" for line in lines) + _CLEAR_BELOW)
        self._out.flush()
        self._shown = len(lines)


@contextmanager
def keys_at_once(terminal: int) -> Iterator[None]:
    """Within this, keys are read as they are pressed and not shown; Ctrl-C still interrupts.

    Those that would halt the program, end it unasked or hold up what it shows are keys like any other: whoever drives
    a robot must not be halted.
    """
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal)
    _let_nothing_halt(terminal)
    sys.stdout.write(_HIDE)
    try:
        yield
    finally:
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)
        sys.stdout.write(_SHOW)
        sys.stdout.flush()


def _let_nothing_halt(terminal: int) -> None:
    settings = termios.tcgetattr(terminal)
    settings[_INPUT] &= ~termios.IXON
    for key in (termios.VSUSP, termios.VQUIT):
        settings[_KEYS_AT][key] = _NO_KEY
    termios.tcsetattr(terminal, termios.TCSANOW, settings)


def pressed(terminal: int) -> bytes:
    """The keys since the last time; never waits. Nothing once the terminal is gone."""
    if not select.select([terminal], [], [], 0)[0]:
        return b""
    try:
        return os.read(terminal, _KEYS)
    except OSError:
        return b""


def drop_stdout() -> None:
    """Where nothing can be written there any more: else Python would try once more on its way out, and complain."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _size(out: TextIO) -> Tuple[int, int]:
    """Columns and rows. A terminal that does not say is taken for a usual one."""
    try:
        size = os.get_terminal_size(out.fileno())
    except OSError:
        return _USUAL
    return size.columns or _USUAL[0], size.lines or _USUAL[1]
