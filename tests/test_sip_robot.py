# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer's sessions: as SIP.md says that real firmware begins, keeps and ends them."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_config import RobotConfig, read_identity
from edgefusion.drivers.sip_frame import Packet, frame
from edgefusion.drivers.sip_status import Status
from edgefusion.sim.sip_robot_character import CHARACTERS, H8, SH, Character
from sip_host import MS, SYNC, Host, kinds


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
