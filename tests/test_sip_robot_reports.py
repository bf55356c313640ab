# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer tells of itself what SIP.md says that real firmware does."""

from __future__ import annotations

import math
import struct

import pytest

from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_frame import frame
from edgefusion.drivers.sip_status import Status
from edgefusion.sim.sip_robot_character import H8, SH, Character
from edgefusion.sim.sip_robot_wheels import WheelTicks
from edgefusion.types import Pose2D
from sip_host import Host


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
