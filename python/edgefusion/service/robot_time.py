# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a process comes to reckon with the robot's clock: at once on the robot's computer, by asking base on another."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import Callable, Iterator

import zenoh

from edgefusion.bus.clock_id import clock_id
from edgefusion.bus.clock_reading import read_clock
from edgefusion.bus.joining import OPENING_S, Joining
from edgefusion.bus.session import open_member
from edgefusion.config import BusConfig
from edgefusion.service.robot_clock import RobotClock
from edgefusion.waiting import Wake, join

ANSWER_S, END_S = 0.2, 0.4
"""The last is more than an answer takes, and little of the time that a process has to end."""
FIRST, FIRST_S, AGAIN_S = 8, 0.05, 2.0
"""So many readings at first, so soon after each other; then one every two seconds."""

Known = Callable[[], "RobotClock | None"]
"""The robot's clock, None before it is known. Raises RuntimeError where the robot's computer was started anew, and
what keeps this one from the bus for good."""


@contextmanager
def robot_time(config: BusConfig, own_id: str | None = None) -> Iterator[Known]:
    """Within this the clock is read again and again, where the router is on another computer. own_id: of this one's."""
    clock = RobotClock(own_id or clock_id())
    if config.connect is None:
        yield lambda: clock
        return
    reader = _Reader(config, clock)
    reader.begin()
    try:
        yield lambda: reader.clock
    finally:
        reader.end()


class _Reader:
    """Of the clock, in a thread, from when there is a bus."""

    def __init__(self, config: BusConfig, clock: RobotClock) -> None:
        self._robot, self._clock, self._readings = config.robot, clock, 0
        self._joining = Joining(lambda: open_member(config, OPENING_S), self._joined)
        self._wake, self._ending = Wake(), False
        self._failure: Exception | None = None
        self._thread: threading.Thread | None = None

    @property
    def clock(self) -> RobotClock | None:
        failure = self._failure or self._joining.failure
        if failure is not None:
            raise failure
        return self._clock if self._readings >= FIRST else None

    def begin(self) -> None:
        self._joining.begin()

    def end(self) -> None:
        self._ending = True
        self._wake()
        if self._thread is not None:
            join(self._thread, END_S)
        self._joining.end()

    def _joined(self, session: zenoh.Session) -> None:
        self._thread = threading.Thread(target=self._run, args=(session,), name="the robot's clock", daemon=True)
        self._thread.start()

    def _run(self, session: zenoh.Session) -> None:
        while not self._ending:
            reading = read_clock(session, self._robot, ANSWER_S)
            if reading is not None:
                try:
                    self._clock.read(reading)
                except RuntimeError as error:
                    self._failure = error
                    return
                self._readings += 1
            self._wake.wait(FIRST_S if self._readings < FIRST else AGAIN_S)
