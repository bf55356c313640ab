# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot that is watched over the bus: in place in a terminal, else line after line."""

from __future__ import annotations

import json
import shutil
import sys
import time
from collections import deque
from typing import Deque

from edgefusion.bus.listener import Listener
from edgefusion.bus.reader import Reader
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.topics import DETECTIONS_DETAIL, key_of
from edgefusion.clock import Clock
from edgefusion.messages.to_detections_detail import Detections, to_detections_detail
from edgefusion.tools.terminal import Screen
from edgefusion.tools.watch_report import Seen, Watched, facts, in_words

TURN_S, SCREEN_S, LINE_S = 0.05, 0.2, 1.0
PATIENCE_S = 3.0
"""So long a robot may take to say something."""

_RATE_NS = 5_000_000_000
_NEWEST = 200


class Watch:
    """What comes of a robot, from when it is made on. Malformed frames are left out."""

    def __init__(self, robot: Listener, clock: Clock) -> None:
        self._robot, self._clock = robot, clock
        key = key_of(robot.name, DETECTIONS_DETAIL.name)
        self._frames = Subscriber(robot.session, key, _NEWEST, clock=clock)
        self._reader = Reader(DETECTIONS_DETAIL, to_detections_detail)
        self._came_ns: Deque[int] = deque()
        self._last: Detections | None = None

    def look(self) -> Watched:
        """As of now."""
        for received in self._frames.take():
            frame = self._reader.read(received.payload)
            if frame is not None:
                self._last = frame
                self._came_ns.append(received.received_ns)
        seen = None if self._last is None else self._seen(self._last)
        return Watched(self._robot.name, self._robot.status, seen)

    def _seen(self, last: Detections) -> Seen:
        age_ns = self._clock() - self._came_ns[-1]
        while self._came_ns[-1] - self._came_ns[0] > _RATE_NS:
            self._came_ns.popleft()
        span_ns = max(self._came_ns[-1] - self._came_ns[0], age_ns)
        return Seen(last, age_ns / 1e9, (len(self._came_ns) - 1) * 1e9 / span_ns if span_ns else 0.0)


def show_in_place(watch: Watch, seconds: float) -> int:
    """Draws it in the terminal five times a second."""
    screen, end_s = Screen(sys.stdout), time.monotonic() + seconds
    while time.monotonic() < end_s:
        rows = shutil.get_terminal_size().lines - 2
        screen.show([*in_words(watch.look())[:rows], "Ctrl-C ends this"])
        time.sleep(SCREEN_S)
    return 0


def tell(watch: Watch, as_json: bool, seconds: float) -> int:
    """Prints it once a second."""
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        time.sleep(min(LINE_S, max(0.0, end_s - time.monotonic())))
        _print(watch.look(), as_json)
    return 0


def tell_once(watch: Watch, as_json: bool) -> int:
    """Prints it when there is something of everything, or what there is after a while. 1 where that is nothing."""
    end_s = time.monotonic() + PATIENCE_S
    watched = watch.look()
    while time.monotonic() < end_s and not watched.says_everything:
        time.sleep(TURN_S)
        watched = watch.look()
    _print(watched, as_json)
    return 0 if watched.says_something else 1


def _print(watched: Watched, as_json: bool) -> None:
    print(json.dumps(facts(watched)) if as_json else "\n".join([*in_words(watched), ""]), flush=True)
