# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer moves as SIP.md says that real firmware does."""

from __future__ import annotations

import math

import pytest

from edgefusion.drivers.sip_command import Command, command, wheel_speeds
from sip_host import ENABLE, Host


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
