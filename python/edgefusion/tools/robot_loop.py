# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How `edgefusion robot` shows a robot: in place in a terminal, else line after line."""

from __future__ import annotations

import json
import sys
import time
from contextlib import nullcontext
from typing import Callable

from edgefusion.tools.robot_keys import HELP, Keys
from edgefusion.tools.robot_report import in_words
from edgefusion.tools.robot_watch import RobotWatch
from edgefusion.tools.terminal import Screen, keys_at_once, pressed

_EVERY_NS, _SCREEN_NS = 1_000_000_000, 200_000_000
"""In a second, a ring of sixteen sonars has fired once."""
_PAUSE_S = 0.01


def tell(watch: RobotWatch, as_json: bool, once: bool, seconds: float) -> int:
    """Prints how it is every second, or once. 1 where it was lost when it should be told once."""

    def show() -> None:
        told = watch.facts()
        print(json.dumps(told) if as_json else "\n".join([*in_words(told), ""]), flush=True)

    _loop(watch, None, show, _EVERY_NS, 1.5 * _EVERY_NS / 1e9 if once else seconds)
    return 1 if once and not watch.has_state else 0


def show_in_place(watch: RobotWatch, keys: Keys | None, seconds: float) -> int:
    """Draws it in the terminal five times a second. keys: what it is driven by; None: it is only looked at."""
    screen = Screen(sys.stdout)

    def show() -> None:
        screen.show([*in_words(watch.facts()), *(f"keys     {line}" for line in (HELP if keys else ("Ctrl-C quits",)))])

    with nullcontext() if keys is None else keys_at_once(sys.stdin.fileno()):
        _loop(watch, keys, show, _SCREEN_NS, seconds)
    return 0


def _loop(watch: RobotWatch, keys: Keys | None, show: Callable[[], None], every_ns: int, seconds: float) -> None:
    begun_ns = shown_ns = time.monotonic_ns()
    there = True
    while time.monotonic_ns() - begun_ns < seconds * 1e9 and not (keys and keys.quit):
        _take(keys)
        was_there, there = there, watch.turn()
        if keys is not None and there and not was_there:
            _take(keys)  # what was typed while it was searched for must not move it now
            keys.let_go()
        if not there:
            time.sleep(_PAUSE_S)
        late_ns = time.monotonic_ns() - shown_ns
        if late_ns >= every_ns or (was_there and not there):
            show()
            shown_ns += late_ns // every_ns * every_ns


def _take(keys: Keys | None) -> None:
    if keys is not None:
        keys.press(pressed(sys.stdin.fileno()), time.monotonic_ns())
