# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer behaves on its wire as SIP.md says that real firmware does."""

from __future__ import annotations

import math

import pytest

from edgefusion.drivers.sip import SipReader
from edgefusion.drivers.sip_command import Command, command, wheel_speeds
from edgefusion.drivers.sip_config import RobotConfig, read_identity
from edgefusion.drivers.sip_frame import Packet, frame
from edgefusion.drivers.sip_status import Status
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import CHARACTERS, H8, SH, Character
from floor_body import FloorBody

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


def test_the_handshake_echoes_each_step_and_ends_with_three_names() -> None:
    host = Host()
    host.say(b"WMS2\r", SYNC[0])  # junk first, as ARIA sends it
    assert kinds(host.wait(50)) == [0]
    host.say(SYNC[1])
    assert kinds(host.wait(50)) == [1]
    host.say(SYNC[2])
    (reply,) = host.wait(100)
    assert read_identity(reply.body).subtype == "p3dx-sh"
    assert not host.robot.open and host.wait(500) == []  # reports begin with OPEN
    host.say(command(Command.OPEN))
    assert isinstance(host.wait(250)[0], Status)


def test_a_step_out_of_turn_is_answered_with_ff_and_the_handshake_begins_again() -> None:
    host = Host()
    host.say(SYNC[2])
    assert kinds(host.wait(50)) == [0xFF]
    host.say(SYNC[1])
    assert kinds(host.wait(50)) == [0xFF]
    assert host.opened().robot.open


def test_in_an_open_session_a_sync_is_a_pulse_and_only_reports_come() -> None:
    host = Host().opened()
    host.say(SYNC[0])
    messages = host.wait(1000)
    assert all(isinstance(message, Status) for message in messages) and len(messages) == pytest.approx(10, abs=1)


def test_at_another_speed_it_is_deaf_and_its_reports_are_noise() -> None:
    host = Host(baudrate=38400)
    host.say(*SYNC)
    assert host.wait(300) == [] and not host.heard
    host.baudrate = 9600
    host.opened()
    host.baudrate, host.heard = 38400, b""
    assert host.wait(500, pulse=False) == [] and host.heard


def test_the_line_of_9600_baud_takes_a_tenth_of_a_second_for_ninety_bytes() -> None:
    host = Host()
    host.say(SYNC[0], SYNC[1], SYNC[2])
    reply = 6 + 6 + 6 + len(b"Simulated_1\0Pioneer\0p3dx-sh\0")
    whole_ms = reply * 10 / 9.6
    host.wait(int(whole_ms) - 1)
    assert len(host.heard) == reply - 1 or len(host.heard) == reply - 2
    host.wait(3)
    assert len(host.heard) == reply


def test_motors_are_off_until_they_are_enabled() -> None:
    host = Host().opened()
    host.say(command(Command.VEL, 300))
    assert not host.status().motors_enabled and host.speed_mps == 0
    host.say(ENABLE)
    host.wait(1500)
    assert host.status().motors_enabled and host.speed_mps == pytest.approx(0.3)
    host.say(command(Command.ENABLE, 0))
    host.wait(1500)
    assert host.speed_mps == 0


@pytest.mark.parametrize("character", [H8, SH], ids=lambda character: character.subtype)
def test_its_counts_are_those_of_its_board(character: Character) -> None:
    host = Host(character).driving()
    host.say(command(Command.VEL, 200))
    host.wait(5000)
    host.say(command(Command.VEL, 0))
    host.wait(2000)
    assert host.status().x_counts == pytest.approx(host.body.odometry.x_m * 1e3 / character.distance_mm, abs=1)


@pytest.mark.parametrize("bits", [15, 16])
def test_its_counts_wrap_below_zero(bits: int) -> None:
    host = Host(Character("p3dx-sh", 1.0, counter_bits=bits)).driving()
    host.say(command(Command.VEL, -200))
    host.wait(2000)
    assert host.status().x_counts > 0x7000


@pytest.mark.parametrize(
    ("packets", "v_mps", "w_dps"),
    [
        ([command(Command.VEL, 250)], 0.25, 0),
        ([command(Command.VEL, -250), command(Command.RVEL, 30)], -0.25, 30),
        ([wheel_speeds(200, 200)], 0.2, 0),
        ([wheel_speeds(-100, 100)], 0.0, math.degrees(100 * 0.0056)),
        ([command(9, 20)], 0, 20),
        ([command(Command.SETV, 100), command(Command.VEL, 400)], 0.1, 0),
        ([command(Command.SETRV, 15), command(Command.RVEL, -40)], 0, -15),
        ([command(Command.VEL, 300), command(Command.STOP)], 0, 0),
    ],
)
def test_velocities_are_driven_within_what_was_set(packets, v_mps: float, w_dps: float) -> None:
    host = Host().driving()
    host.say(*packets)
    host.wait(3000)
    status = host.status()
    assert (status.left_speed + status.right_speed) / 2000 == pytest.approx(v_mps, abs=2e-3)
    assert status.turn_ddps / 10 == pytest.approx(w_dps, abs=0.6)


@pytest.mark.parametrize(
    ("packet", "x_m", "degrees"),
    [
        (command(Command.HEAD, 90), 0, 90),
        (command(Command.DHEAD, -45), 0, -45),
        (command(8, 500), 0.5, 0),
        (command(8, -200), -0.2, 0),
    ],
)
def test_headings_and_distances_are_reached_and_kept(packet: bytes, x_m: float, degrees: float) -> None:
    host = Host().driving()
    host.say(packet)
    host.wait(12000)
    assert host.body.odometry.x_m == pytest.approx(x_m, abs=0.02)
    assert math.degrees(host.body.odometry.theta) == pytest.approx(degrees, abs=2)


def test_an_emergency_stop_needs_no_ramp() -> None:
    host = Host().driving()
    host.say(command(Command.VEL, 300))
    host.wait(1500)
    host.say(command(Command.E_STOP))
    assert host.speed_mps == 0
    host.wait(500)
    assert host.speed_mps == 0


def test_it_stops_after_two_seconds_of_silence_and_goes_on_by_itself_when_it_hears_something() -> None:
    host = Host().driving()
    host.say(command(Command.VEL, 300))
    host.wait(1900, pulse=False)
    assert host.speed_mps == pytest.approx(0.3)
    host.wait(1500, pulse=False)
    assert host.speed_mps == 0
    host.say(command(Command.PULSE))
    host.wait(1200)
    assert host.speed_mps == pytest.approx(0.3)


def test_seto_makes_here_the_origin() -> None:
    host = Host().driving()
    host.say(command(Command.VEL, 200), command(Command.RVEL, 20))
    host.wait(3000)
    host.say(command(Command.STOP))
    host.wait(1500)
    assert host.status().x_counts > 100
    host.say(frame(b"\x07\x3b"))  # cut short, as p2os sends it
    status = host.status()
    assert (status.x_counts, status.y_counts, status.heading_counts) == (0, 0, 0)


@pytest.mark.parametrize(("kind", "believed"), [("right", True), ("wrong", True), ("missing", False)])
def test_its_parameters_come_whole_damaged_or_not_at_all(kind, believed: bool) -> None:
    host = Host(Character("p3dx-sh", 1.0, config_packet=kind)).opened()
    host.say(command(Command.CONFIG, 1))
    found = [message for message in host.wait(500) if isinstance(message, RobotConfig)]
    assert bool(found) is believed
    if found:
        assert (found[0].watchdog_ms, found[0].autobaud, found[0].top_speed_mmps, found[0].firmware) == (
            2000,
            2,
            1000,
            "S.0",
        )


def test_a_new_speed_holds_until_the_session_ends() -> None:
    host = Host().opened()
    host.say(command(Command.HOSTBAUD, 2))
    host.baudrate = 38400
    assert isinstance(host.status(), Status)
    host.say(command(Command.CLOSE, 1))
    assert host.wait(300) == []
    host.baudrate = 9600
    assert host.opened().robot.open


def test_each_sonar_fires_every_320_ms_and_reports_that_once() -> None:
    host = Host().opened()
    host.body.echoes = {3: 1.5, 12: 0.8}
    fired = [sonar for message in host.wait(640) if isinstance(message, Status) for sonar in message.sonars]
    assert sorted({sonar.number for sonar in fired}) == list(range(16))
    assert len(fired) == pytest.approx(32, abs=6)
    assert {sonar.number: sonar.range_counts for sonar in fired}[3] == 1500
    assert {sonar.range_counts for sonar in fired} == {1500, 800, 5000}
    host.say(command(Command.SONAR, 0))
    host.wait(150)
    assert host.status().sonars == ()


def test_the_button_switches_the_motors_off_and_letting_it_go_does_not_switch_them_on() -> None:
    host = Host().driving()
    host.say(command(Command.VEL, 300))
    host.wait(1000)
    host.robot.e_stop_pressed = True
    status = host.status()
    assert status.e_stop_pressed and not status.motors_enabled and host.speed_mps == 0
    host.robot.e_stop_pressed = False
    host.say(command(Command.VEL, 300))
    host.wait(500)
    assert host.speed_mps == 0 and not host.status().motors_enabled


def test_bumpers_stalls_battery_and_digital_lines_are_reported() -> None:
    host = Host().opened()
    host.body.bumpers = ((False, True, False, False, False), (True,) + (False,) * 4)
    host.body.stalled = (True, False)
    host.robot.battery_dv, host.robot.digital_in = 117, 0x0A
    host.say(command(Command.DIGOUT, 0x0302))
    host.wait(150)
    status = host.status()
    assert (status.bumpers_front, status.bumpers_rear, status.stall_left, status.stall_right) == (2, 1, True, False)
    assert (status.battery_dv, status.digital_in, status.digital_out) == (117, 0x0A, 0x02)


@pytest.mark.parametrize(("number", "kind"), [(19, 0x90), (40, 0xF0)])
def test_encoders_and_lines_come_once_or_with_every_report(number: int, kind: int) -> None:
    host = Host(baudrate=None).opened()
    host.heard = b""
    extra = bytes([0xFA, 0xFB])

    def count(argument: int) -> int:
        host.heard = b""
        host.say(command(number, argument))
        host.wait(1000)
        return sum(part[1:2] == bytes([kind]) for part in host.heard.split(extra))

    assert count(1) == 1
    assert count(2) == pytest.approx(10, abs=1)
    assert count(0) <= 1


def test_after_a_power_cycle_it_is_closed_with_its_motors_off_and_its_counts_at_zero() -> None:
    host = Host().driving()
    host.say(command(Command.VEL, 300))
    host.wait(2000)
    host.robot.power_cycle(host.now_ns, 0.5)
    assert host.speed_mps == 0 and host.wait(400) == []
    host.say(*SYNC)
    assert host.wait(300) == []  # still off when it was said
    status = host.opened().status()
    assert not status.motors_enabled and status.x_counts == 0


def test_a_host_that_speaks_before_the_reports_begin_is_not_forgotten() -> None:
    host = Host().opened()
    assert [told.number for _, told in host.robot.heard[:4]] == [0, 1, 2, 1]


def test_characters_are_known_by_their_subtypes() -> None:
    assert CHARACTERS == {"p3dx": H8, "p3dx-sh": SH}
