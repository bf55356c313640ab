# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The robot as its thread owns it: reports come out, the newest command goes in."""

from __future__ import annotations

import threading
from typing import NamedTuple, Protocol, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.pioneer_motion import MAX_AGE_NS
from edgefusion.drivers.pioneer_sonar import SonarRing
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.types import Health, HealthState, Twist2D


class RobotReport(NamedTuple):
    """rear_points_m [k, 2]: what the rear sonar hears, in base_link. session: which start of the robot it is from."""

    state: RobotState
    rear_points_m: npt.NDArray[np.float64]
    session: int


class RobotDriver(Protocol):
    """As drivers.pioneer.Pioneer is: not for several threads; health: as of its last state."""

    @property
    def health(self) -> Health: ...

    def start(self) -> None: ...

    def poll(self) -> list[RobotState]: ...

    def drive(self, twist: Twist2D, given_ns: int | None = None) -> None: ...

    def stop(self) -> None: ...

    def enable_motors(self) -> None: ...

    def close(self) -> None: ...


class RobotDevice:
    """drive() and enable_motors() are anybody's, the rest is the thread's.

    A command is handed to the driver once, and not when it is old, as in a process that was halted: where no new one
    comes, the driver itself stops the robot after 0.3 s. A report by which the robot must not be driven is answered by
    a stop at once, without asking the loop.
    """

    def __init__(self, driver: RobotDriver, clock: Clock = system_clock) -> None:
        self._driver, self._clock = driver, clock
        self._lock = threading.Lock()
        self._command: Tuple[int, Twist2D] | None = None
        self._enable = False
        self._session = 0
        self._ring = SonarRing()

    @property
    def health(self) -> Health:
        return self._driver.health

    def drive(self, stamp_ns: int, twist: Twist2D, session: int) -> None:
        """To be sent within 20 ms. stamp_ns: when it was worked out. session: of the report that it rests on; it does
        not move a robot that was started anew since."""
        with self._lock:
            if session == self._session:
                self._command = stamp_ns, twist

    def enable_motors(self) -> None:
        """Where somebody has switched them off; nothing moves by that."""
        with self._lock:
            self._enable = True

    def start(self) -> None:
        """As the driver's. What was commanded before is forgotten."""
        with self._lock:
            self._session += 1
            self._command, self._enable = None, False
        self._ring = SonarRing()
        self._driver.start()

    def poll(self) -> Sequence[RobotReport]:
        """As the driver's; and hands it what is to be sent."""
        reports = [self._report(state) for state in self._driver.poll()]
        with self._lock:
            command, self._command = self._command, None
            enable, self._enable = self._enable, False
        if self._driver.health.state is HealthState.FAILED:
            command = None
            if reports:
                self._driver.stop()
        if enable:
            self._driver.enable_motors()
        if command is not None and self._clock() - command[0] <= MAX_AGE_NS:
            self._driver.drive(command[1], command[0])
        return reports

    def close(self) -> None:
        """As the driver's: the last it says is to stop."""
        self._driver.close()

    def _report(self, state: RobotState) -> RobotReport:
        self._ring.add(state)
        return RobotReport(state, self._ring.rear_points_m(state.stamp_ns), self._session)
