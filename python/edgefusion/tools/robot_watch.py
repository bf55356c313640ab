# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot that is watched and driven by hand, and found again when it was lost."""

from __future__ import annotations

from collections import deque
from typing import Any, Deque

from edgefusion.clock import Clock
from edgefusion.drivers.backoff import Backoff
from edgefusion.drivers.link import LinkError
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_sonar import SonarRing
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.tools.robot_keys import Keys
from edgefusion.tools.robot_report import Counted, facts
from edgefusion.types import Twist2D

_DRIVE_NS, _RATE_NS = 50_000_000, 5_000_000_000


class RobotWatch:
    """keys: None where nobody drives."""

    def __init__(self, port: str, driver: Pioneer, keys: Keys | None, clock: Clock) -> None:
        self._port, self._driver, self._keys, self._clock = port, driver, keys, clock
        self._backoff = Backoff()
        self._ring = SonarRing()
        self._state: RobotState | None = None
        self._came_ns: Deque[int] = deque()
        self._begun_ns = clock()
        self._sessions = 0
        self._told, self._told_ns = Twist2D(), 0

    @property
    def has_state(self) -> bool:
        """Whether it has something to tell."""
        return self._state is not None

    def begin(self) -> None:
        """Finds the robot; what was pressed before does not move it. Raises LinkError, RefusedError."""
        self._driver.start()
        if self._keys is not None:
            self._keys.let_go()
        self._sessions += 1
        self._begun_ns, self._told = self._clock(), Twist2D()
        self._came_ns.clear()

    def turn(self) -> bool:
        """Some 20 ms of it; a search takes seconds. Whether there is a robot. Raises RefusedError."""
        try:
            if self._driver.info is None:
                if not self._backoff.due(self._clock()):
                    return False
                self.begin()
                self._backoff.reset()
            if self._keys is not None:
                self._obey(self._keys)
            self._take(self._driver.poll())
        except LinkError:
            self._state = None
            self._backoff.failed(self._clock())
        return self._driver.info is not None

    def facts(self) -> dict[str, Any]:
        """As of now."""
        now_ns = self._clock()
        while self._came_ns and now_ns - self._came_ns[0] > _RATE_NS:
            self._came_ns.popleft()
        seconds = min(_RATE_NS, now_ns - self._begun_ns) / 1e9
        rate = len(self._came_ns) / seconds if seconds else 0.0
        counted = Counted(rate, max(0, self._sessions - 1))
        return facts(self._port, self._driver, self._state, self._ring.ranges_m(now_ns), counted)

    def _take(self, states: list[RobotState]) -> None:
        for state in states:
            self._state = state
            self._ring.add(state)
            self._came_ns.append(self._clock())

    def _obey(self, keys: Keys) -> None:
        now_ns = self._clock()
        if keys.motors_switched():
            self._driver.enable_motors(self._state is None or not self._state.motors_enabled)
        twist = keys.twist(now_ns)
        if twist == self._told == Twist2D() or (twist == self._told and now_ns - self._told_ns < _DRIVE_NS):
            return
        self._driver.stop() if twist == Twist2D() else self._driver.drive(twist)
        self._told, self._told_ns = twist, now_ns
