# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The driver of a Pioneer: from any state to driving, its states, and a stop at every end."""

from __future__ import annotations

import math
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Callable

from edgefusion.clock import Clock, system_clock
from edgefusion.config.navigation import BaseConfig
from edgefusion.config.pioneer import PioneerConfig
from edgefusion.drivers import pioneer_motion
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.pioneer_connect import find, go_faster, open_session
from edgefusion.drivers.pioneer_factors import Factors, factors_for
from edgefusion.drivers.pioneer_judgement import COMPONENT, Judgement
from edgefusion.drivers.pioneer_limits import Limits, limits_of
from edgefusion.drivers.pioneer_line import PioneerLine, RobotError
from edgefusion.drivers.pioneer_odometry import Odometry
from edgefusion.drivers.pioneer_state import RobotState, robot_state
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_config import Identity, RobotConfig
from edgefusion.drivers.sip_status import Status
from edgefusion.errors import RefusedError
from edgefusion.types import STILL, Health, HealthState, Twist2D

SILENCE_S = 0.25
"""Two and a half of a Pioneer's cycles."""

MOTORS_S = 1.0
"""How long the motors may take to be on."""

_RESET_STATUSES = 3
"""SETO takes effect in one of the next SIPs."""

_STANDING_MPS, _STANDING_RADPS = 0.005, 0.02


@dataclass(frozen=True)
class RobotInfo:
    """What is connected. parameters: None where the robot sent no CONFIGpac."""

    identity: Identity
    parameters: RobotConfig | None
    factors: Factors
    limits: Limits
    baudrate: int


class Pioneer:
    """One robot on a link. base: how fast it may go.

    Not for several threads. After a LinkError start() begins anew, from any state of the robot; nothing moves then
    until a new drive(), and the motors stay off if the robot has switched them off. Leaving the `with` block stops it.
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
        self._usual_baudrate = link.baudrate
        self._line = PioneerLine(link, clock, pause)
        self._motion = pioneer_motion.Motion(config.velocities == "wheels", 0.0, 0.0)
        self._info: RobotInfo | None = None
        self._state: RobotState | None = None
        self._odometry: Odometry | None = None
        self._judgement = Judgement(config, base)
        self._may_enable = config.enable_motors
        self._resets_left = 0
        self.implausible_statuses = 0
        self._health = Health(COMPONENT, HealthState.STARTING, "not started")

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
        return self._info

    @property
    def state(self) -> RobotState | None:
        """The newest; None before the first."""
        return self._state

    @property
    def line(self) -> PioneerLine:
        """For what it counts."""
        return self._line

    def start(self) -> None:
        """From any state of the robot to an open session. Raises LinkError, RefusedError for an unknown robot."""
        try:
            self._link.open()
            self._link.expect_within(math.inf)
            identity = find(self._line, self._config.baudrates)
            factors = factors_for(identity.subtype, self._config)
            parameters = open_session(self._line)
            go_faster(self._line, parameters, self._config.faster_baudrate)
            limits = limits_of(self._base, parameters)
            self._line.send(*limits.packets(), command(Command.PULSE))
            self._line.send(command(Command.SONAR, int(self._config.sonar)))
            self._begin(RobotInfo(identity, parameters, factors, limits, self._link.baudrate))
            self._enable_once()
            self._link.expect_within(SILENCE_S)
        except Exception as error:
            self._fail(error)
            raise

    def poll(self) -> list[RobotState]:
        """The states that came within 20 ms; sends what is due. Raises LinkError where the robot is lost."""
        if self._info is None:
            raise RobotError(f"{self._link.name}: expected start() before poll()")
        try:
            states = [state for message in self._line.receive() for state in self._states(message)]
            packets = self._motion.due(self._clock())
            if packets:
                self._line.send(*packets)
            return states
        except Exception as error:
            self._fail(error)
            raise

    def drive(self, twist: Twist2D) -> None:
        """The velocity to keep for the next 0.3 s, clipped to what the robot may; then it is zero. Raises LinkError."""
        self._require_started()
        self._line.send(*self._motion.drive(self._clock(), twist))

    def turn_by(self, angle: float) -> None:
        """Turns on the spot, left positive [rad], by the robot's own control: no age ends it. Raises LinkError."""
        self._say(Command.DHEAD, round(math.degrees(angle)))

    def turn_to(self, heading: float) -> None:
        """The same to a heading in `odom` [rad]. Raises LinkError, RobotError before the first state."""
        self._require_started()
        if self._state is None:
            raise RobotError(f"{self._link.name}: expected a state before turn_to()")
        self.turn_by(math.remainder(heading - self._state.odometry.theta, 2 * math.pi))

    def stop(self) -> None:
        """Stops with the usual braking; the motors stay on. Raises LinkError."""
        self._require_started()
        self._motion.forget(self._clock())
        self._line.send(*pioneer_motion.STOP)

    def emergency_stop(self) -> None:
        """Stops as hard as it can. Raises LinkError."""
        self._say(Command.E_STOP)

    def enable_motors(self, on: bool = True) -> None:
        """Says so; whether they are on the next states tell. Raises LinkError."""
        self._say(Command.ENABLE, int(on))

    def set_sonar(self, on: bool) -> None:
        """Raises LinkError."""
        self._require_started()
        self._line.send(command(Command.SONAR, int(on)))

    def set_digital_outputs(self, mask: int, values: int) -> None:
        """Those of the mask's bits, 8 each. Raises LinkError, RefusedError."""
        for name, value in (("mask", mask), ("values", values)):
            if not 0 <= value <= 0xFF:
                raise RefusedError(f"{name}: expected 0 to 255, got {value}")
        self._require_started()
        self._line.send(command(Command.DIGOUT, mask << 8 | values))

    def reset_odometry(self) -> None:
        """The pose begins at STILL again. Raises LinkError, RefusedError while the robot moves: it would be lost where
        it gets to meanwhile."""
        self._require_started()
        twist = self._state.twist if self._state else Twist2D()
        if abs(twist.v_mps) > _STANDING_MPS or abs(twist.w_radps) > _STANDING_RADPS:
            raise RefusedError(f"reset_odometry: expected a robot that stands, got {twist.v_mps:.2f} m/s")
        self._line.send(command(Command.SETO))
        self._resets_left = _RESET_STATUSES
        if self._odometry is not None:
            self._odometry.pose = STILL

    def close(self) -> None:
        """Stops the robot, ends the session, and gives the port to others. Raises nothing."""
        if self._link.is_open:
            with suppress(LinkError):
                self._line.send(*pioneer_motion.STOP, command(Command.CLOSE, 1))
        self._link.close()
        self._lost(Health(COMPONENT, HealthState.STARTING, "not started"))

    def _say(self, number: Command, argument: int | None = None) -> None:
        """What takes the place of a velocity."""
        self._require_started()
        self._motion.forget(self._clock())
        self._line.send(command(number, argument))

    def _begin(self, info: RobotInfo) -> None:
        self._info = info
        self._motion = pioneer_motion.Motion(
            self._config.velocities == "wheels", info.limits.speed_mps, info.limits.yaw_rate_radps
        )
        pose = STILL if self._odometry is None else self._odometry.pose
        self._odometry = Odometry(info.factors, pose)
        self._judgement = Judgement(self._config, self._base)
        self._state, self._resets_left = None, 0

    def _enable_once(self) -> None:
        """At the first start alone: motors that go off while it is at work were switched off by somebody."""
        if not self._may_enable:
            return
        self._line.send(command(Command.ENABLE, 1))
        deadline_ns = self._clock() + round(MOTORS_S * 1e9)
        while self._clock() <= deadline_ns:
            if any(state.motors_enabled for message in self._line.receive() for state in self._states(message)):
                self._may_enable = False
                return
        # Its states say what is in the way.

    def _states(self, message: object) -> list[RobotState]:
        if not isinstance(message, Status) or self._info is None or self._odometry is None:
            return []
        now_ns = self._clock()
        if self._resets_left:
            self._resets_left -= 1
            self._odometry.begin_anew()
        if not self._odometry.add(now_ns, message):
            self.implausible_statuses += 1
            return []
        self._state = robot_state(message, self._info.factors, self._odometry.pose, now_ns)
        self._health = self._judgement.judge(self._state, self._motion.commanded)
        return [self._state]

    def _require_started(self) -> None:
        if self._info is None:
            raise RobotError(f"{self._link.name}: expected start() before it is told anything")

    def _fail(self, error: Exception) -> None:
        if self._link.is_open:
            with suppress(LinkError):
                self._line.send(*pioneer_motion.STOP)
        self._lost(Health(COMPONENT, HealthState.FAILED, " ".join(str(error).split()) or type(error).__name__))

    def _lost(self, health: Health) -> None:
        self._info = None
        self._state = None
        self._health = health
