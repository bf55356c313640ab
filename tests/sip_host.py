# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A host on the line of a simulated Pioneer."""

from __future__ import annotations

from edgefusion.drivers.sip import SipReader
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_frame import Packet, frame
from edgefusion.drivers.sip_status import Status
from edgefusion.sim.floor_body import FloorBody
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import SH, Character

MS = 1_000_000
SYNC = [frame(bytes([step])) for step in range(3)]
ENABLE = command(Command.ENABLE, 1)


class Host:
    """On a robot's line, in a time of its own that goes in milliseconds."""

    def __init__(self, character: Character = SH, baudrate: int | None = 9600) -> None:
        self.body = FloorBody()
        self.robot = SipRobot(self.body, character)
        self.reader = SipReader()
        self.now_ns, self.baudrate, self.heard = 0, baudrate, b""

    def say(self, *packets: bytes) -> None:
        self.robot.receive(b"".join(packets), self.baudrate, self.now_ns)

    def wait(self, ms: int, pulse: bool = True) -> list:
        """What came meanwhile."""
        found = []
        for passed in range(ms):
            self.now_ns += MS
            self.body.base.step(MS)
            if pulse and passed % 500 == 0 and self.robot.open:
                self.say(command(Command.PULSE))
            data = self.robot.transmit(self.baudrate, self.now_ns)
            self.heard += data
            found += self.reader.feed(data)
        return found

    def opened(self) -> Host:
        for packet in SYNC:
            self.say(packet)
            assert self.wait(100)
        self.say(command(Command.OPEN, 1))
        self.wait(200)
        return self

    def driving(self) -> Host:
        self.opened().say(ENABLE)
        return self

    def status(self) -> Status:
        return [message for message in self.wait(250) if isinstance(message, Status)][-1]

    @property
    def speed_mps(self) -> float:
        return self.body.twist.v_mps


def kinds(messages: list) -> list[int]:
    return [message.type for message in messages if isinstance(message, Packet)]
