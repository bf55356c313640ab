# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The codec of the Pioneer's protocol: known packets, recorded connections, and noise."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.drivers.sip import SipReader, is_packet
from edgefusion.drivers.sip_command import Command, command, wheel_speeds
from edgefusion.drivers.sip_config import AUTOBAUD_RESETS, RobotConfig, read_config, read_identity
from edgefusion.drivers.sip_frame import Packet, PacketFinder, checksum, frame
from edgefusion.drivers.sip_status import Status, read_status
from edgefusion.errors import RefusedError
from sip_traces import REAL_CONFIG_START, read_trace, sip, sip_body

BODIES = st.binary(min_size=1, max_size=253)
IDENTITY = bytes.fromhex("fafb1b02414d524953696d0050696f6e6565720070336478 2d736800 5f52")


@pytest.mark.parametrize(
    ("packet", "expected"),
    [
        (command(Command.PULSE), "fafb03000000"),
        (command(1), "fafb03010001"),
        (command(2), "fafb03020002"),
        (command(Command.OPEN, 1), "fafb06013b0100023b"),
        (command(Command.ENABLE, 1), "fafb06043b0100053b"),
        (command(Command.VEL, 250), "fafb060b3bfa00053b"),
        (command(Command.VEL, -250), "fafb060b1bfa00051b"),
        (command(Command.RVEL, -10), "fafb06151b0a001f1b"),
        (command(Command.CLOSE, 1), "fafb06023b0100033b"),
    ],
)
def test_documented_commands_are_encoded(packet, expected):
    assert packet == bytes.fromhex(expected)


def test_a_text_has_its_length_first():
    assert command(3, b"\x01\x02")[3:-2] == b"\x03\x2b\x02\x01\x02"


def test_wheel_speeds_go_as_twos_complement_in_a_signed_magnitude():
    assert wheel_speeds(200, -100) == command(32, (10 << 8) | (-5 & 0xFF))
    assert wheel_speeds(-20, 20) == command(32, -0xFF)


@pytest.mark.parametrize(
    "make",
    [
        lambda: command(256),
        lambda: command(11, 0x10000),
        lambda: command(15, bytes(198)),
        lambda: wheel_speeds(0, 2560),
        lambda: frame(b""),
        lambda: frame(bytes(254)),
    ],
)
def test_what_no_packet_holds_is_refused(make):
    with pytest.raises(RefusedError, match="expected"):
        make()


def test_an_odd_body_has_its_last_byte_xored_into_the_checksum():
    assert checksum(IDENTITY[3:-2]) == 0x5F52


@given(st.lists(BODIES, max_size=8), st.data())
def test_packets_survive_any_chunking(bodies, data):
    stream = b"".join(frame(body) for body in bodies)
    finder, found = PacketFinder(), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        found += finder.feed(stream[:size])
        stream = stream[size:]
    assert [packet.body for packet in found] == bodies
    assert finder.skipped_bytes == 0


@given(st.lists(st.binary(max_size=300), max_size=8))
def test_every_byte_of_noise_belongs_to_a_packet_is_skipped_or_waits_in_at_most_one_packet(chunks):
    finder, in_packets = PacketFinder(is_packet), 0
    for chunk in chunks:
        in_packets += sum(len(packet.body) + 5 for packet in finder.feed(chunk))
    in_packets += sum(len(packet.body) + 5 for packet in finder.give_up())
    assert in_packets + finder.skipped_bytes == sum(len(chunk) for chunk in chunks)


MEAN_BYTES = st.lists(st.sampled_from([0xFA, 0xFB, 0x03, 0x06, 0x20, 0x32, 0x00, 0xFF]), max_size=60).map(bytes)
REAL = st.sampled_from([sip(x=1, sonars=[(3, 900)]), sip(left=-200), IDENTITY, command(Command.VEL, 250), frame(b"\0")])


@st.composite
def damaged(draw: st.DrawFn) -> bytes:
    """Real packets among bytes that mean something, with some of all changed and some cut out."""
    stream = bytearray(b"".join(draw(st.lists(st.one_of(REAL, MEAN_BYTES), max_size=8))))
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, len(stream)))
        stream[at : at + draw(st.integers(0, 3))] = draw(st.binary(max_size=2))
    return bytes(stream)


@given(damaged(), st.data())
def test_damaged_packets_raise_nothing_and_say_the_same_in_any_pieces(stream, data):
    whole, reader, said = SipReader(), SipReader(), []
    expected = whole.feed(stream) + whole.give_up()
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        said += reader.feed(stream[:size])
        stream = stream[size:]
    said += reader.give_up()
    assert said == expected
    assert (reader.unknown_packets, reader.finder.skipped_bytes) == (whole.unknown_packets, whole.finder.skipped_bytes)


@given(st.binary(max_size=30).filter(lambda junk: b"\xfa" not in junk), BODIES)
def test_junk_before_a_packet_is_skipped_and_counted(junk, body):
    finder = PacketFinder()
    (packet,) = finder.feed(junk + frame(body))
    assert (packet.body, packet.end, finder.skipped_bytes) == (body, len(junk + frame(body)), len(junk))


def test_a_packet_behind_a_false_header_is_found_from_the_next_byte_on():
    assert [packet.body for packet in PacketFinder().feed(b"\xfa\xfb\x06" + 2 * frame(b"\x05"))] == [b"\x05", b"\x05"]
    assert [packet.body for packet in PacketFinder().feed(b"\xfa" + frame(b"\x05"))] == [b"\x05"]
    assert [packet.body for packet in PacketFinder().feed(b"\xfa\xfb\x02" + frame(b"\x05"))] == [b"\x05"]


def test_a_silent_line_gives_up_what_a_false_count_waits_for():
    reader = SipReader()
    assert reader.feed(b"\xfa\xfb\xff" + sip(x=7)) == []
    (status,) = reader.give_up()
    assert status.x_counts == 7
    assert reader.feed(sip(x=8))[0].x_counts == 8


def test_bytes_forgotten_do_not_join_what_comes_later():
    finder = PacketFinder()
    finder.feed(frame(b"\x05")[:4])
    finder.clear()
    assert finder.feed(frame(b"\x05")[4:]) == []
    assert finder.feed(frame(b"\x06"))[0].end == 12


def test_a_status_is_read_field_by_field():
    tail = bytes([1, 2, 3, 4, 5]) + bytes.fromhex("7b00 01 f6ff 0200 0300 80 58")
    body = sip_body(x=0x8005, y=9, heading=-3, left=-200, right=100, rear=5, front=2, sonars=[(0, 5000), (9, 300)])
    status = read_status(body + tail)
    assert (status.x_counts, status.y_counts, status.heading_counts) == (5, 9, -3)
    assert (status.left_speed, status.right_speed) == (-200, 100)
    assert (status.stall_left, status.stall_right) == (True, False)
    assert (status.bumpers_rear, status.bumpers_front) == (2, 1)
    assert [tuple(sonar) for sonar in status.sonars] == [(0, 5000), (9, 300)]
    assert (status.gripper, status.analog_port, status.analog) == (1, 2, 3)
    assert (status.digital_in, status.digital_out) == (4, 5)
    assert (status.battery_dv, status.charge_state, status.turn_ddps, status.faults) == (123, 1, -10, 2)
    assert (status.lateral_speed, status.temperature_c, status.charge_percent) == (3, -128, 88)


@pytest.mark.parametrize("tail_bytes", range(25))
def test_a_status_of_any_length_is_read_as_far_as_it_goes(tail_bytes):
    status = read_status(sip_body(sonars=[(3, 1)], tail=bytes(tail_bytes)))
    assert (status.gripper is None) == (tail_bytes < 1)
    assert (status.digital_out is None) == (tail_bytes < 5)
    assert status.battery_dv == 120  # a second voltage of 0 says nothing either
    assert (status.charge_percent is None) == (tail_bytes < 16)


@pytest.mark.parametrize("count", [0, 1, 8, 16, 32])
@pytest.mark.parametrize("kind", [0x30, 0x32, 0x33, 0x3F])
def test_a_status_has_any_number_of_sonars(count, kind):
    assert len(read_status(sip_body(sonars=[(i, i) for i in range(count)], kind=kind)).sonars) == count


def test_flags_tell_motors_and_e_stop():
    assert [read_status(sip_body(flags=flags)).motors_enabled for flags in (0x1E, 0x1F)] == [False, True]
    assert [read_status(sip_body(flags=flags)).e_stop_pressed for flags in (0x1F, 0x20)] == [False, True]


@pytest.mark.parametrize(
    "body",
    [
        b"",
        sip_body()[:-1],
        sip_body(kind=0x40),
        sip_body(sonars=[(1, 2)])[:-1],
        sip_body(heading=4097),
        sip_body(left=3001),
        sip_body(right=-3001),
        sip_body(sonars=[(64, 1)]),
        sip_body(sonars=[(1, 1), (1, 1)]),
    ],
)
def test_a_status_that_no_pioneer_sends_is_refused_whatever_its_checksum(body):
    with pytest.raises(RefusedError, match="status: expected"):
        read_status(body)
    if body:
        assert SipReader().feed(frame(body)) == []


def test_the_names_of_the_handshake_are_read():
    (packet,) = SipReader().feed(IDENTITY)
    assert isinstance(packet, Packet)
    identity = read_identity(packet.body)
    assert (identity.name, identity.type, identity.subtype) == ("AMRISim", "Pioneer", "p3dx-sh")
    with pytest.raises(RefusedError, match="text: expected"):
        read_identity(packet.body[:-1])


def test_a_real_robots_config_is_read_in_spite_of_its_wrong_checksum():
    reader = SipReader()
    missing = 0x89 - 2 - len(REAL_CONFIG_START[3:])
    (config,) = reader.feed(REAL_CONFIG_START + bytes(missing) + b"\xde\xad" + sip())[:1]
    assert (config.subtype, config.serial, config.name) == ("p3dx-sh", "GJC_3156", "FAPESP_3156")
    assert (config.top_turn_dps, config.top_speed_mmps, config.sip_cycle_ms) == (360, 1000, 100)
    assert reader.finder.skipped_bytes == 0


def test_a_short_config_leaves_the_rest_open():
    config = read_config(REAL_CONFIG_START[3:])
    assert (config.sip_cycle_ms, config.watchdog_ms, config.firmware) == (100, None, None)


@pytest.mark.parametrize("body", [b"\x21", bytes([0x20]) + bytes(40), REAL_CONFIG_START[3:30], b"\x20" + b"\xff" * 50])
def test_what_is_no_config_is_refused(body):
    with pytest.raises(RefusedError, match="expected"):
        read_config(body)
    assert not is_packet(body, True) or body[0] != 0x20


def test_unknown_packets_are_skipped_and_counted():
    reader = SipReader()
    messages = reader.feed(frame(b"\x90\x01\x02") + sip(x=1) + frame(b"\xf0\x00"))
    assert [message.x_counts for message in messages] == [1]
    assert (reader.unknown_packets, reader.finder.skipped_bytes) == (2, 0)


def test_of_a_stream_with_errors_the_intact_packets_are_kept():
    random_ = random.Random(1)
    reader, intact, read = SipReader(), set(), []
    for i in range(5000):
        sonars = [(j, random_.randrange(5000)) for j in range(random_.randrange(5))]
        packet = bytearray(sip(x=i, left=random_.randrange(-300, 300), sonars=sonars))
        hit = [k for k in range(len(packet)) if random_.random() < 0.01]
        for k in hit:
            packet[k] ^= random_.randrange(1, 256)
        if not hit:
            intact.add(i)
        read += reader.feed(bytes(packet))
    read += reader.give_up()
    kept = {status.x_counts for status in read if isinstance(status, Status)}
    assert len(intact) > 3000
    assert len(intact - kept) <= 0.001 * len(intact)
    assert len(read) - len(intact & kept) <= 10


@pytest.mark.parametrize("trace", ["sip_capture.hex", "sip_session1.hex"])
def test_recorded_robots_are_read_whole(shared_data, trace):
    packets = read_trace(shared_data / "sip" / trace, "R")
    reader = SipReader()
    messages = reader.feed(b"".join(packet for packet, _ in packets))
    assert len(packets) > 200
    assert len(messages) + reader.unknown_packets == len(packets)
    assert reader.finder.skipped_bytes == 0
    assert reader.unknown_packets == sum(packet[3] == 0x61 for packet, _ in packets)
    statuses = [message for message in messages if isinstance(message, Status)]
    assert all(len(status.sonars) == 16 and status.battery_dv == 130 for status in statuses)
    (config, *_) = (message for message in messages if isinstance(message, RobotConfig))
    assert (config.watchdog_ms, config.autobaud, config.firmware) == (2000, AUTOBAUD_RESETS, "S.0")


def test_recorded_commands_are_found_all_but_the_broken_one(shared_data):
    packets = read_trace(shared_data / "sip" / "sip_capture.hex", "C")
    finder = PacketFinder()
    found = finder.feed(b"".join(packet for packet, _ in packets))
    assert [holds for _, holds in packets].count(False) == 1
    assert [frame(packet.body) for packet in found] == [packet for packet, holds in packets if holds]
    assert finder.skipped_bytes == 9
