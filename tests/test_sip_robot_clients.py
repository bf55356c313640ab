# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Other people's hosts at the simulated Pioneer: what they are known to say, in their order and their haste."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Iterable, Iterator

import pytest

from edgefusion.drivers.pioneer_factors import HEADING
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_config import read_identity
from edgefusion.drivers.sip_frame import Packet, PacketFinder, frame
from edgefusion.drivers.sip_status import STATUS_TYPES, Status, read_status
from edgefusion.sim.floor_body import FloorBody
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import H8, SH, Character

MS = 1_000_000
SYNC = [frame(bytes([step])) for step in range(3)]
OPEN, PULSE, CLOSE = (command(each) for each in (Command.OPEN, Command.PULSE, Command.CLOSE))
LINE = re.compile(r"\s*([\d.]+) ([CR])>\S+ id=\S+ n=\s*\d+ ck=ok\s+(.*)")


class Robot:
    """On a host's line. Its bytes wait until the host reads them, as in a port's buffer."""

    def __init__(self, character: Character = SH, baudrate: int | None = 9600) -> None:
        self.body = FloorBody()
        self.firmware = SipRobot(self.body, character)
        self.finder = PacketFinder()
        self.now_ns, self.baudrate, self.waiting = 0, baudrate, b""

    def say(self, *packets: bytes) -> None:
        self.firmware.receive(b"".join(packets), self.baudrate, self.now_ns)

    def wait(self, ms: int) -> None:
        for _ in range(ms):
            self.now_ns += MS
            self.body.base.step(MS)
            self.waiting += self.firmware.transmit(self.baudrate, self.now_ns)

    def flush(self) -> None:
        self.waiting, self.finder = b"", PacketFinder()

    def packet(self, within_ms: int = 1000) -> Packet | None:
        """The next one; none where it takes too long or is broken."""
        for _ in range(within_ms):
            while self.waiting:
                byte, self.waiting = self.waiting[:1], self.waiting[1:]
                for packet in self.finder.feed(byte):
                    return packet
            self.wait(1)
        return None

    def status(self) -> Status:
        """The newest."""
        self.flush()
        while True:
            packet = self.packet()
            assert packet is not None
            if packet.type in STATUS_TYPES:
                return read_status(packet.body)


def shaken(robot: Robot, tries: int = 0) -> Packet:
    """The last reply, as hosts get there that say a step again as soon as something else than its echo comes."""
    step = 0
    while True:
        robot.say(SYNC[step])
        reply = robot.packet()
        if reply is None or reply.type != step:
            assert tries > 0
            tries -= 1
        elif step == 2:
            return reply
        else:
            step += 1


@pytest.mark.parametrize("character", [H8, SH], ids=lambda character: character.subtype)
@pytest.mark.parametrize("before", ["closed", "open", "opened and torn away"])
def test_a_host_that_closes_first_at_every_speed_and_repeats_steps_gets_in(character: Character, before: str) -> None:
    robot = Robot(character)
    if before != "closed":
        shaken(robot, tries=4)
        robot.say(OPEN)
        robot.wait(5000 if before == "opened and torn away" else 523)
    for baudrate in (115200, 57600, 38400, 19200, 9600):
        robot.baudrate = baudrate
        robot.say(CLOSE)
        robot.flush()
    assert read_identity(shaken(robot, tries=4).body).subtype == character.subtype
    robot.say(OPEN)
    assert not robot.status().motors_enabled


@pytest.mark.parametrize("begun", range(3))
def test_a_host_that_finds_a_handshake_begun_by_another_gets_in(begun: int) -> None:
    robot = Robot()
    robot.say(*SYNC[:begun])
    robot.wait(200)
    robot.flush()
    robot.say(CLOSE)
    assert shaken(robot, tries=4).type == 2


def test_a_host_that_asks_an_open_session_is_answered_with_reports_and_closes_it() -> None:
    robot = Robot()
    shaken(robot)
    robot.say(OPEN, PULSE)
    robot.wait(500)
    robot.flush()
    robot.say(SYNC[0])
    stale = robot.packet()
    assert stale is not None and stale.type in STATUS_TYPES
    robot.say(CLOSE)
    robot.wait(400)
    robot.flush()
    shaken(robot)
    robot.say(OPEN, PULSE)
    robot.say(command(Command.SONAR, 0), command(Command.SETA, 200), command(Command.SETA, -200))
    robot.say(command(Command.ENABLE, 1), command(Command.VEL, 200))
    robot.wait(1800)
    assert robot.status().left_speed == 200 and robot.status().sonars == ()
    robot.say(command(Command.STOP), CLOSE)
    robot.wait(2000)
    assert robot.body.twist.v_mps == 0 and not robot.firmware.open


def test_a_host_that_sends_the_whole_handshake_at_once_gets_in() -> None:
    robot = Robot()
    robot.say(b"WMS2\r", *SYNC, OPEN, PULSE)
    assert isinstance(robot.status(), Status)


def test_a_host_that_raises_the_speed_hears_a_report_in_time_and_finds_the_usual_one_after_closing() -> None:
    robot = Robot()
    shaken(robot)
    robot.say(OPEN)
    robot.wait(150)
    robot.say(command(Command.HOSTBAUD, 2))
    robot.wait(10)
    robot.baudrate = 38400
    robot.flush()
    robot.say(PULSE)
    assert robot.packet(900) is not None
    robot.say(command(Command.CLOSE, 1))
    robot.baudrate = 9600
    robot.flush()
    assert shaken(robot).type == 2


def test_an_iopac_has_four_bytes_of_inputs_as_a_p3s() -> None:
    robot = Robot(baudrate=None)
    robot.body.bumpers = ((True, False, False, False, False), (False, True, False, False, False))
    robot.firmware.reports.digital_in = 0x21
    shaken(robot)
    robot.say(OPEN, command(Command.DIGOUT, 0x0F05), command(40, 1))
    packet = robot.packet()
    assert packet is not None and packet.body == bytes([0xF0, 4, 0x21, 1, 2, 0, 1, 0x05, 0])


def recorded(path: Path, side: str) -> Iterator[tuple[int, bytes]]:
    """Its packets of one side in the first connection, each with its time [ns]."""
    for line in path.read_text().splitlines():
        if "EOF" in line:
            return
        found = LINE.match(line)
        if found and found[2] == side:
            yield round(float(found[1]) * 1e9), bytes.fromhex(found[3])


def last_status(packets: Iterable[tuple[int, bytes]]) -> Status:
    return [read_status(packet[3:-2]) for _, packet in packets if packet[3] in STATUS_TYPES][-1]


def test_a_recorded_session_of_aria_drives_it_to_where_it_drove_the_recorded_robot(shared_data: Path) -> None:
    trace = shared_data / "sip" / "sip_session1.hex"
    robot, replies = Robot(baudrate=None), list(recorded(trace, "R"))
    for then_ns, packet in recorded(trace, "C"):
        robot.wait((then_ns - robot.now_ns) // MS)
        robot.say(packet)
    robot.wait(500)
    said = [(0, frame(packet.body)) for packet in PacketFinder().feed(robot.waiting)]
    kinds = [list(dict.fromkeys(packet[3] & 0xFE for _, packet in side)) for side in (said, replies)]
    assert kinds[0] == kinds[1] and not robot.firmware.open
    ours, theirs = last_status(said), last_status(replies)
    assert ours.x_counts == pytest.approx(theirs.x_counts, abs=25)
    assert ours.y_counts == pytest.approx(theirs.y_counts, abs=25)
    turned = math.degrees((ours.heading_counts - theirs.heading_counts) * HEADING)
    assert turned == pytest.approx(0, abs=1)
