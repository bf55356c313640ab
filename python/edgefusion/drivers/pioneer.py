# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The driver of a Pioneer: from any state to driving, its states, and a stop at every end."""

from __future__ import annotations

import math
import time
from contextlib import contextmanager, suppress
from typing import Callable, Iterator

from edgefusion.clock import Clock, system_clock
from edgefusion.config.navigation import BaseConfig
from edgefusion.config.pioneer import PioneerConfig
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.pioneer_info import RobotInfo
from edgefusion.drivers.pioneer_judgement import COMPONENT
from edgefusion.drivers.pioneer_line import PioneerLine, RobotError
from edgefusion.drivers.pioneer_motion import STOP
from edgefusion.drivers.pioneer_session import Session, begin
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.drivers.sip_command import Command, command
from edgefusion.errors import RefusedError
from edgefusion.types import STILL, Health, HealthState, Twist2D

_NOT_STARTED = Health(COMPONENT, HealthState.STARTING, "not started")


class Pioneer:
    """One robot on a link. base: how fast it may go.

    Not for several threads. After a LinkError start() begins anew, from any state of the robot: its pose goes on where
    it was, nothing moves until a new drive(), and motors that are off then stay off. Leaving the `with` block stops it.
    """

    def __init__(
        self,
        link: Link,
        config: PioneerConfig,
        base: BaseConfig,
        clock: Clock = system_clock,
        pause: Callable[[float], None] = time.sleep,
    ) -> None:
        self._link, self._config, self._base, self._clock = link, config, base, clock
        self.line = PioneerLine(link, clock, pause)
        self._session: Session | None = None
        self._pose = STILL
        self._may_enable = config.enable_motors
        self._health = _NOT_STARTED

    def __enter__(self) -> Pioneer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def health(self) -> Health:
        """As of the last state or failure."""
        return self._health

    @property
    def info(self) -> RobotInfo | None:
        """What is connected; None before the start, and after it was lost."""
        return self._session.info if self._session else None

    @property
    def implausible_statuses(self) -> int:
        """How many SIPs of this session were left out, since they do not follow from those before."""
        return self._session.reports.implausible if self._session else 0

    def start(self) -> None:
        """From any state of the robot to an open session, with its motors enabled at the first time.

        Motors that stay off are no error: the health says so, and what is in the way. Raises LinkError, RefusedError
        for a robot whose counts nobody knows.
        """
        with self._stopped_by_any_error():
            self._session = None
            self._link.expect_within(math.inf)
            self._link.open()
            session = begin(self.line, self._config, self._base, self._pose)
            if self._may_enable:
                session.enable_motors()
            session.await_state()
            # Motors that go off while it is at work were switched off by somebody, who is to switch them on again.
            self._may_enable = False
            self._link.expect_within(session.info.silence_s)
            self._session = session
            self._take_over(session)

    def poll(self) -> list[RobotState]:
        """The states that came within 20 ms; sends what is due. Raises LinkError where the robot is lost."""
        session = self._started("poll")
        with self._stopped_by_any_error():
            due = session.motion.due(self._clock())
            if due:
                self.line.send(*due)
            states = session.receive()
            self._take_over(session)
            return states

    def drive(self, twist: Twist2D, given_ns: int | None = None) -> None:
        """The velocity to keep until 0.3 s after it was worked out, clipped to what the robot may; then it is zero.

        given_ns: when that was, by the driver's clock; by default now. Raises LinkError.
        """
        motion = self._started("drive").motion
        self._say(*motion.drive(self._clock(), twist, given_ns))

    def turn_by(self, angle: float) -> None:
        """Turns on the spot, left positive [rad], by the robot's own control: no age ends it.

        Raises LinkError, RefusedError.
        """
        motion = self._started("turn_by").motion
        self._say(*motion.turn_by(self._clock(), angle))

    def turn_to(self, heading: float) -> None:
        """The same to a heading in `odom` [rad]. Raises LinkError, RefusedError."""
        session = self._started("turn_to")
        self._say(*session.motion.turn_to(self._clock(), session.reports.robot_heading(heading)))

    def stop(self) -> None:
        """Stops with the usual braking; the motors stay on. Raises LinkError."""
        motion = self._started("stop").motion
        self._say(*motion.stop(self._clock()))

    def e_stop(self) -> None:
        """Stops as hard as it can. Raises LinkError."""
        motion = self._started("e_stop").motion
        self._say(command(Command.E_STOP), *motion.drive(self._clock(), Twist2D()))

    def enable_motors(self, on: bool = True) -> None:
        """Says so; whether they are on the next states tell. Nothing moves until a new drive(). Raises LinkError."""
        motion = self._started("enable_motors").motion
        self._say(*motion.stop(self._clock()), command(Command.ENABLE, int(on)))

    def set_sonar(self, on: bool) -> None:
        """All of it. Raises LinkError."""
        self._started("set_sonar")
        self._say(command(Command.SONAR, int(on)))

    def set_digital_outputs(self, mask: int, values: int) -> None:
        """Those of the mask's bits, 8 each. Raises LinkError, RefusedError."""
        for name, value in (("mask", mask), ("values", values)):
            if not 0 <= value <= 0xFF:
                raise RefusedError(f"{name}: expected 0 to 255, got {value}")
        self._started("set_digital_outputs")
        self._say(command(Command.DIGOUT, mask << 8 | values))

    def reset_odometry(self) -> None:
        """The pose begins at STILL again. Raises LinkError, RefusedError while the robot moves: where it gets to until
        its counts begin anew would be lost."""
        reports = self._started("reset_odometry").reports
        if not reports.stands:
            raise RefusedError("reset_odometry: expected a robot that stands, got one that moves")
        self._say(command(Command.SETO))
        reports.reset_pose()
        self._pose = STILL

    def close(self) -> None:
        """Stops the robot, ends the session, and gives the port to others. Raises nothing.

        The motors of one that stands are switched off; one that moves needs them to brake.
        """
        if self._link.is_open:
            stands = self._session is not None and self._session.reports.stands
            off = [command(Command.ENABLE, 0)] if stands else []
            with suppress(LinkError):
                self.line.send(*STOP, *off, command(Command.CLOSE, 1))
        self._link.close()
        self._session, self._health = None, _NOT_STARTED
        self._may_enable = self._config.enable_motors

    def _say(self, *packets: bytes) -> None:
        with self._stopped_by_any_error():
            self.line.send(*packets)

    def _take_over(self, session: Session) -> None:
        self._pose = session.reports.pose
        self._health = session.reports.health

    def _started(self, what: str) -> Session:
        if self._session is None:
            raise RobotError(f"{self._link.name}: expected start() before {what}()")
        return self._session

    @contextmanager
    def _stopped_by_any_error(self) -> Iterator[None]:
        """Whatever goes wrong, the robot is told to stop, as far as it can be told."""
        try:
            yield
        except BaseException as error:
            if self._link.is_open:
                with suppress(LinkError):
                    self.line.send(*STOP)
            if self._session is not None:
                self._pose = self._session.reports.pose
            reason = " ".join(str(error).split()) or type(error).__name__
            self._session, self._health = None, Health(COMPONENT, HealthState.FAILED, reason)
            raise
