# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One open session with a Pioneer: how it is begun, and what comes in it."""

from __future__ import annotations

from edgefusion.config.navigation import BaseConfig
from edgefusion.config.pioneer import PioneerConfig
from edgefusion.drivers.pioneer_connect import find, go_faster, open_session
from edgefusion.drivers.pioneer_factors import factors_for
from edgefusion.drivers.pioneer_info import RobotInfo
from edgefusion.drivers.pioneer_limits import limits_of
from edgefusion.drivers.pioneer_line import PioneerLine, RobotError
from edgefusion.drivers.pioneer_motion import Motion
from edgefusion.drivers.pioneer_reports import Reports
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.drivers.sip import Message
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_frame import Packet
from edgefusion.drivers.sip_status import Status
from edgefusion.types import Pose2D

NONSENSE_S = 1.0
"""So long it may say nothing that makes sense to who listens."""

_TURN_NS = 100_000_000
"""No turn listens for longer: a process that was halted has not heard nonsense meanwhile."""

_MOTOR_TRIES, _MOTORS_S = 3, 0.35


class Session:
    """info: what is connected. motion: what it is told. reports: what it says."""

    def __init__(self, line: PioneerLine, info: RobotInfo, motion: Motion, reports: Reports) -> None:
        self._line = line
        self.info, self.motion, self.reports = info, motion, reports
        self._turn_ns, self._nonsense_ns = line.clock(), 0

    def receive(self) -> list[RobotState]:
        """The states that came within 20 ms.

        Raises LinkError, also where the robot began anew, or says nothing that makes sense.
        """
        messages = self._line.receive()
        newest_ns, behind = self._newest_ns(len(messages)), reversed(range(len(messages)))
        states = [state for message, b in zip(messages, behind) for state in self._states(message, newest_ns, b)]
        before_ns, self._turn_ns = self._turn_ns, self._line.clock()
        self._nonsense_ns = 0 if states else self._nonsense_ns + min(self._turn_ns - before_ns, _TURN_NS)
        if self._nonsense_ns > NONSENSE_S * 1e9:
            raise RobotError(f"{self._line.link.name}: the robot said nothing that makes sense for {NONSENSE_S:g} s")
        return states

    def enable_motors(self) -> None:
        """Until a state says that they are on, or a second has gone by: what is in the way its states say then."""
        for _ in range(_MOTOR_TRIES):
            self._line.send(command(Command.ENABLE, 1))
            if self._come_on():
                return

    def await_state(self) -> None:
        """Raises LinkError where none comes."""
        while self.reports.state is None:
            self.receive()

    def _come_on(self) -> bool:
        deadline_ns = self._line.clock() + round(_MOTORS_S * 1e9)
        while self._line.clock() <= deadline_ns:
            if any(state.motors_enabled for state in self.receive()):
                return True
        return False

    def _newest_ns(self, count: int) -> int:
        """When the newest of so many messages was sent: where several waited, nobody saw it come, and their pace since
        the last one tells."""
        came_ns, last = self._line.message_ns, self.reports.state
        if count < 2 or last is None:
            return came_ns
        return max(came_ns - self.info.cycle_ns, min(came_ns, last.stamp_ns + count * self.info.cycle_ns))

    def _states(self, message: Message, newest_ns: int, behind: int) -> list[RobotState]:
        """behind: how many have come after it, where the reader was held up: a cycle later each."""
        if isinstance(message, Packet):  # a reply to a handshake that nobody began: to the number of PULSE
            raise RobotError(f"{self._line.link.name}: the robot began anew")
        if not isinstance(message, Status):
            return []
        # What it was told when it said what comes late, nobody knows any more.
        commanded = None if behind else self.motion.commanded
        state = self.reports.add(newest_ns - behind * self.info.cycle_ns, message, commanded)
        return [] if state is None else [state]


def begin(line: PioneerLine, config: PioneerConfig, base: BaseConfig, pose: Pose2D) -> Session:
    """From any state of the robot to one that reports, whose limits are set. pose: where it is now, in `odom`.

    Raises LinkError, RefusedError for a robot whose counts nobody knows.
    """
    identity = find(line, config.baudrates)
    factors = factors_for(identity.subtype, config)
    parameters = open_session(line)
    go_faster(line, parameters, config.faster_baudrate)
    limits = limits_of(base, parameters)
    motion = Motion(config.velocities == "wheels", limits.speed_mps, limits.yaw_rate_radps)
    line.send(*limits.packets(), *motion.due(line.clock()))
    line.send(command(Command.SONAR, int(config.sonar)))
    baudrate = None if line.is_socket else line.link.baudrate
    info = RobotInfo(identity, parameters, factors, limits, baudrate)
    return Session(line, info, motion, Reports(config, limits, factors, pose))
