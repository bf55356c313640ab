# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer behaves on its wire as SIP.md says that real firmware does."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.drivers.sip import SipReader
from edgefusion.drivers.sip_command import Command, command, wheel_speeds
from edgefusion.drivers.sip_config import RobotConfig, read_identity
from edgefusion.drivers.sip_frame import Packet, frame
from edgefusion.drivers.sip_status import Status
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import CHARACTERS, H8, SH, Character
from edgefusion.sim.sip_robot_wheels import WheelTicks
from edgefusion.types import Pose2D
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
    host.say(SYNC[0], SYNC[2])
    assert kinds(host.wait(50)) == [0, 0xFF]
    host.say(SYNC[1])
    assert kinds(host.wait(50)) == []
    assert host.opened().robot.open


def test_closing_what_is_closed_is_not_answered_and_does_not_disturb_the_handshake() -> None:
    host = Host()
    host.say(command(Command.CLOSE), SYNC[0])
    assert kinds(host.wait(50)) == [0]
    assert host.opened().robot.open


def test_nothing_is_heard_of_a_session_after_it_was_closed() -> None:
    host = Host().opened()
    while not host.robot.line.busy:
        host.wait(1)
    host.say(command(Command.CLOSE, 1))
    host.heard = b""
    assert host.wait(300) == [] and host.heard == b""


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


@pytest.mark.parametrize(
    ("packets", "degrees"),
    [
        ([command(Command.HEAD, 180)], 180),
        ([command(Command.SETRV, 40), command(Command.DHEAD, -170)], -170),
        ([command(Command.DHEAD, 60), command(22, 30)], 90),
    ],
)
def test_a_long_turn_ends_where_it_should_without_going_beyond(packets: list[bytes], degrees: float) -> None:
    host = Host().driving()
    host.say(*packets)
    turned = []
    for _ in range(80):
        host.wait(100)
        turned.append(math.degrees(host.body.odometry.theta) * math.copysign(1, degrees))
    assert max(turned) <= abs(degrees) + 1 and turned[-1] == pytest.approx(abs(degrees), abs=2)


def test_a_long_way_ends_where_it_should_without_going_beyond() -> None:
    host = Host().driving()
    host.say(command(8, 3000))
    ways_m = []
    for _ in range(150):
        host.wait(100)
        ways_m.append(host.body.odometry.x_m)
    assert max(ways_m) <= 3.01 and ways_m[-1] == pytest.approx(3, abs=0.01)


@pytest.mark.parametrize(("number", "of"), [(Command.SETA, 0.1), (Command.SETRA, math.radians(20))])
def test_ramps_are_as_gentle_as_the_host_wants_them(number: int, of: float) -> None:
    host = Host().driving()
    command_of, turns = (Command.RVEL, True) if number == Command.SETRA else (Command.VEL, False)
    rate = 20 if turns else 100

    def speed() -> float:
        return host.body.twist.w_radps if turns else host.body.twist.v_mps

    host.say(command(number, rate), command(number, -2 * rate), command(command_of, 3 * rate))
    host.wait(1000)
    assert speed() == pytest.approx(of, rel=0.05)
    host.wait(3000)
    assert speed() == pytest.approx(3 * of, rel=0.01)
    host.say(command(command_of, 0))
    host.wait(1000)
    assert speed() == pytest.approx(of, rel=0.05)


@pytest.mark.parametrize(("stalls_on", "stops"), [(0, False), (1, True), (2, False), (3, True)])
def test_a_bump_stalls_and_stops_it_where_it_was_told_so(stalls_on: int, stops: bool) -> None:
    host = Host().driving()
    host.say(command(Command.BUMPSTALL, stalls_on), command(Command.VEL, 200))
    host.wait(1500)
    host.body.bumpers = ((True,) + (False,) * 4, (False,) * 5)
    host.wait(1500)
    status = host.status()
    assert (host.speed_mps == 0, status.stall_left, status.stall_right) == (stops, stops, stops)
    host.say(command(Command.VEL, -100))
    host.wait(1500)
    assert host.speed_mps == pytest.approx(-0.1)  # so it gets away


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


@pytest.mark.parametrize(
    "packet",
    [
        command(3, bytes([1, 2, 3, 4, 9])),
        frame(bytes([3, 0x2B, 5, 1, 2, 3, 4, 9, 0])),
        frame(bytes([3, 0x2B, 1, 2, 3, 4, 9, 0])),
    ],
    ids=["length", "length and zero byte", "zero byte"],
)
def test_a_text_is_understood_as_any_host_sends_it(packet: bytes) -> None:
    host = Host().opened()
    host.say(packet)
    assert host.robot.heard[-1][1].text == bytes([1, 2, 3, 4, 9])


def test_sonars_fire_in_the_order_and_at_the_pace_they_are_polled() -> None:
    host = Host(baudrate=None).opened()
    host.say(command(3, bytes([2, 9, 2, 5, 40, 0])), command(48, 20))
    host.wait(200)
    reports = [message.sonars for message in host.wait(500) if isinstance(message, Status)]
    assert [{sonar.number for sonar in each} for each in reports] == [{1, 4, 8}] * 5
    host.say(command(48, 1000))
    host.wait(1000)
    assert sum(len(message.sonars) for message in host.wait(3000) if isinstance(message, Status)) == 6


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
    host.robot.reports.battery_dv, host.robot.reports.digital_in = 117, 0x0A
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


def encoders(host: Host) -> tuple[int, int]:
    host.heard = b""
    host.say(command(19, 1))
    host.wait(100)
    begin = host.heard.index(b"\xfa\xfb\x0b\x90") + 4
    return struct.unpack("<ii", host.heard[begin : begin + 8])


def test_each_wheel_counts_its_way_forward_and_back_whatever_the_direction() -> None:
    host = Host(baudrate=None).driving()
    host.say(command(Command.HEAD, 90))
    host.wait(5000)
    turned = host.body.odometry.theta / 0.0056 * 128
    assert encoders(host) == (pytest.approx(-turned, abs=2000), pytest.approx(turned, abs=2000))
    left, right = encoders(host)
    host.say(command(8, -500))
    host.wait(8000)
    way = math.hypot(host.body.odometry.x_m, host.body.odometry.y_m) * 1e3 * 128
    assert encoders(host) == (pytest.approx(left - way, abs=600), pytest.approx(right - way, abs=600))
    host.say(command(Command.SETO))
    assert encoders(host) == (pytest.approx(left - way, abs=600), pytest.approx(right - way, abs=600))


def test_wheels_that_have_gone_far_count_on_from_below_zero() -> None:
    wheels = WheelTicks(128, Pose2D(0, 0, 0))
    for metres in range(1, 20_001, 10):
        wheels.roll_to(Pose2D(float(metres), 0, 0))
    way = 19_991_000 * 128
    assert wheels.ticks == (way - 2**32, way - 2**32)


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


def test_a_robot_may_say_nothing_to_a_step_out_of_turn() -> None:
    host = Host(Character("p3dx", 0.485, says_out_of_step=False))
    host.say(SYNC[0], SYNC[2])
    assert kinds(host.wait(300)) == [0] and host.opened().robot.open


def test_a_step_is_answered_again_when_it_is_said_again() -> None:
    host = Host()
    host.say(SYNC[0], SYNC[0], SYNC[1], SYNC[1], SYNC[2], SYNC[2], command(Command.OPEN))
    assert kinds(host.wait(300)) == [0, 0, 1, 1, 2, 2]
    assert host.robot.open


def test_a_recorded_host_is_answered_as_its_robot_did(shared_data) -> None:
    """ARIA's connection, drive and farewell, each packet at its time."""
    host, heard = Host(baudrate=None), []
    trace = [line.split() for line in (shared_data / "sip" / "sip_session1.hex").read_text().splitlines()]
    sent = [(float(line[0]), line) for line in trace if len(line) > 6 and line[1] == "C>R"]
    recorded = [int(line[2][5:], 16) for line in trace if len(line) > 6 and line[1] == "R>C"]
    for at_s, line in sent:
        heard += host.wait(max(0, round(at_s * 1e3 - host.now_ns / MS)), pulse=False)
        host.say(bytes.fromhex("".join(line[line.index("ck=ok") + 1 :])))
    heard += host.wait(300, pulse=False)
    replies = [1 if isinstance(message, Status) else 2 for message in heard if not isinstance(message, Packet)]
    assert kinds(heard) == [kind for kind in recorded if kind in (0, 1, 2)]
    assert replies[0] == 2 and replies.count(2) == recorded.count(0x20)
    assert replies.count(1) == pytest.approx(recorded.count(0x32), rel=0.05)
    assert any(message.motors_enabled and message.left_speed > 100 for message in heard if isinstance(message, Status))
    assert not host.robot.open and not host.robot.drive.motors


@settings(max_examples=25, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=60), st.binary(min_size=1, max_size=20).map(frame)), max_size=30))
def test_whatever_a_host_says_it_goes_on_and_is_found_again(said: list[bytes]) -> None:
    host = Host(baudrate=None)
    host.say(*SYNC, command(Command.OPEN))
    for data in said:
        host.say(data)
        host.robot.transmit(None, host.now_ns)
        host.now_ns += 100 * MS
        host.body.base.step(100 * MS)
    host.say(bytes(300), command(Command.CLOSE), command(Command.CLOSE), command(Command.HOSTBAUD, 0))
    host.wait(600)
    assert host.opened().robot.open and isinstance(host.status(), Status)


def test_of_what_it_heard_it_remembers_the_newest_only() -> None:
    host = Host(baudrate=None).opened()
    for _ in range(30):
        host.say(command(Command.PULSE) * 1000, command(Command.VEL, 7))
    assert 10_000 <= len(host.robot.heard) <= 20_000 and host.robot.heard[-1][1].argument == 7


def test_characters_are_known_by_their_subtypes() -> None:
    assert CHARACTERS == {"p3dx": H8, "p3dx-sh": SH}
