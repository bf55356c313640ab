# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The injectors do what their words say, to whole frames where they know them, and nothing outside of their time."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.drivers.lms2xx_scan import parse_scan
from edgefusion.drivers.lms2xx_telegram import TelegramReader, encode
from edgefusion.drivers.sip import SipReader
from edgefusion.drivers.sip_status import Status
from edgefusion.errors import RefusedError
from edgefusion.sim.fault_frames import LMS, SIP, Frames
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import KINDS, Fault, parse_fault
from edgefusion.sim.live_camera import Picture
from edgefusion.sim.wire_line import PacedLine
from sip_traces import sip

MS = 1_000_000
S = 1_000 * MS


class Says:
    """A device that says what it is given, and remembers what it heard."""

    def __init__(self) -> None:
        self.line = PacedLine(9600)
        self.heard, self.says = b"", b""

    def receive(self, data: bytes, baudrate: int | None, now_ns: int) -> None:
        self.heard += data

    def transmit(self, baudrate: int | None, now_ns: int) -> bytes:
        said, self.says = self.says, b""
        return said


class Spoilt:
    """Packets of a robot through a fault, one every 100 ms."""

    def __init__(self, text: str, packets=None, protocol=SIP) -> None:
        self.device, self.now_ns = Says(), 0
        self.wire = FaultyWire(self.device, protocol, parse_fault(text), np.random.default_rng(1), 0)
        self.packets = packets or [sip(x=10 * i) for i in range(200)]

    def run(self, count: int = 40) -> list[bytes]:
        """What came of each."""
        came = []
        for packet in self.packets[:count]:
            self.now_ns += 100 * MS
            self.device.says = packet
            came.append(self.wire.transmit(9600, self.now_ns))
        return came

    def trickled(self, count: int = 40, share: int = 7) -> bytes:
        """What came of all, where a packet takes its 100 ms in so many pieces."""
        came = b""
        for packet in self.packets[:count]:
            size = -(-len(packet) // share)
            for begin in range(0, share * size, size):
                self.now_ns += 100 * MS // share
                self.device.says = packet[begin : begin + size]
                came += self.wire.transmit(9600, self.now_ns)
        return came


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("laser=stuck", Fault("laser", "stuck", 0.0)),
        ("laser=garbage:0.001", Fault("laser", "garbage", 0.001)),
        ("robot=delayed", Fault("robot", "delayed", 0.3)),
        ("camera=off@5", Fault("camera", "off", 0.0, 5.0)),
        ("robot=off:17@5.5+2", Fault("robot", "off", 17.0, 5.5, 2.0)),
    ],
)
def test_a_fault_is_written_as_component_kind_value_and_time(text: str, fault: Fault) -> None:
    assert parse_fault(text) == fault


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("laser", "expected COMPONENT=KIND"),
        ("wheel=off", "expected one of robot, laser, camera, got 'wheel'"),
        ("laser=broken", "expected one of off, stuck, garbage, wrong, slow, delayed, intermittent, got 'broken'"),
        ("laser=garbage:7", "expected a share from 0 to 1, got 7"),
        ("laser=slow:0.5", "expected at least 1, got 0.5"),
        ("laser=slow:1.2.3", "expected numbers"),
        ("laser=off@-1", "expected COMPONENT=KIND"),
        ("laser=stuck:5", "laser=stuck: expected no value, got 5"),
        ("robot=wrong:0.5", "robot=wrong: expected no value, got 0.5"),
        ("camera=off:3", "camera=off: expected no value, got 3"),
    ],
)
def test_a_fault_that_is_none_is_refused_with_what_is_known(text: str, why: str) -> None:
    with pytest.raises(RefusedError) as refused:
        parse_fault(text)
    assert why in str(refused.value)


@pytest.mark.parametrize("kind", KINDS)
def test_before_and_after_its_time_everything_is_well(kind: str) -> None:
    spoilt = Spoilt(f"robot={kind}@1.05+1")
    came = spoilt.run()
    assert came[:10] == spoilt.packets[:10] and came[22:40] == spoilt.packets[22:40]
    assert came[10:20] != spoilt.packets[10:20] or kind == "intermittent"


def test_off_is_silent_and_deaf_after_so_many_bytes_more() -> None:
    spoilt = Spoilt("robot=off:40")
    assert b"".join(spoilt.run()) == b"".join(spoilt.packets)[:40]
    spoilt.wire.receive(b"hello", 9600, spoilt.now_ns)
    assert spoilt.device.heard == b""


@pytest.mark.parametrize("offset", [1, 2, 3, 20])
def test_off_in_mid_packet_counts_from_a_packets_first_byte(offset: int) -> None:
    spoilt = Spoilt(f"robot=off:{offset}@1.05")
    assert spoilt.trickled() == b"".join(spoilt.packets)[: 11 * len(spoilt.packets[0]) + offset]


@pytest.mark.parametrize("share", [3, 7, 60])
@pytest.mark.parametrize("kind", ["stuck", "wrong", "slow", "intermittent"])
def test_in_any_pieces_packets_are_spoilt_whole_and_faults_begin_and_end_between_two(kind: str, share: int) -> None:
    spoilt = Spoilt(f"robot={kind}@1.05+1")
    reader = SipReader()
    found = [status.x_counts for status in reader.feed(spoilt.trickled(share=share))]
    before, after = list(range(0, 110, 10)), list(range(210, 400, 10))
    assert found[:11] == before and found[-19:] == after
    assert reader.finder.skipped_bytes == 0 and reader.finder.is_between_packets
    between = {"stuck": [100] * 10, "slow": [140, 180]}
    assert found[11:-19] == between.get(kind, found[11:-19])
    assert found[11:-19] != list(range(110, 210, 10))


def test_what_is_no_packet_is_let_be_when_packets_are_spoilt() -> None:
    telegram = encode(b"\xb0" + bytes(9), 0x80)
    spoilt = Spoilt("laser=stuck", [b"\x06" + telegram, b"\x15", encode(b"\xb2", 0x80)], LMS)
    assert spoilt.run() == [b"\x06" + telegram, b"\x15", telegram]


def test_stuck_repeats_the_last_whole_packet_at_the_pace_of_new_ones() -> None:
    spoilt = Spoilt("robot=stuck@1.05")
    came = spoilt.run()
    assert came[10:] == [spoilt.packets[9]] * 30


def test_garbage_spoils_so_many_of_the_bytes() -> None:
    spoilt = Spoilt("robot=garbage:0.1")
    sent, came = b"".join(spoilt.packets), b"".join(spoilt.run(200))
    differing = sum(a != b for a, b in zip(sent, came))
    assert len(came) == len(sent) and differing / len(sent) == pytest.approx(0.1, abs=0.015)


def test_wrong_reports_are_whole_and_not_true() -> None:
    spoilt = Spoilt("robot=wrong")
    reader = SipReader()
    found = [status for part in spoilt.run() for status in reader.feed(part)]
    assert len(found) == 40 and all(isinstance(status, Status) for status in found)
    assert len({status.x_counts for status in found}) > 35


def test_wrong_scans_are_whole_and_not_true() -> None:
    payload = b"\xb0\xb5\x40" + (2000).to_bytes(2, "little") * 181 + b"\x10"
    spoilt = Spoilt("laser=wrong", [encode(payload, 0x80)] * 5, LMS)
    reader = TelegramReader()
    scans = [parse_scan(item.payload).values for part in spoilt.run(5) for item in reader.feed(part)]
    assert len(scans) == 5 and all(len(np.unique(values)) > 100 for values in scans)


def test_slow_lets_one_of_so_many_through_and_intermittent_a_share() -> None:
    assert sum(map(bool, Spoilt("robot=slow:4").run())) == 10
    assert sum(map(bool, Spoilt("robot=intermittent:0.25").run(200))) == pytest.approx(150, abs=20)


def test_delayed_packets_come_in_order_and_as_late_as_it_says() -> None:
    spoilt = Spoilt("robot=delayed:0.3")
    came = spoilt.run()
    assert came[:3] == [b""] * 3 and came[3:] == spoilt.packets[:37]


@given(st.lists(st.binary(max_size=30)), st.integers(0, 10**6))
def test_whatever_is_said_frames_lose_nothing(noise: list[bytes], seed: int) -> None:
    rng = np.random.default_rng(seed)
    stream = b"".join(part + sip(x=i) for i, part in enumerate(noise)) + sip()
    frames, cut, at = Frames(SIP), [], 0
    while at < len(stream):
        size = int(rng.integers(1, 40))
        cut += frames.feed(stream[at : at + size])
        at += size
    assert stream.startswith(b"".join(cut)) and len(stream) - len(b"".join(cut)) < 258


def picture(number: int) -> Picture:
    image = np.full((48, 64, 3), 10 * number, np.uint8)
    return Picture(number * 50 * MS, cv2.imencode(".jpg", image)[1].tobytes())


def brightness(jpeg: bytes) -> float:
    return float(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).mean())


def through(text: str, count: int = 20) -> list[list[Picture]]:
    spoiler = FaultyPictures(parse_fault(text), np.random.default_rng(1), 0)
    return [spoiler.sent(picture(number), number * 50 * MS) for number in range(1, count + 1)]


def test_a_camera_that_is_off_stuck_or_covered() -> None:
    assert through("camera=off") == [[]] * 20
    stuck = [sent.jpeg for came in through("camera=stuck@0.5") for sent in came]
    assert len(stuck) == 20 and len(set(stuck[9:])) == 1 and len(set(stuck[:9])) == 9
    assert [brightness(sent.jpeg) for came in through("camera=wrong") for sent in came] == [0.0] * 20


def test_a_camera_that_is_slow_late_or_broken() -> None:
    assert sum(map(len, through("camera=slow:5"))) == 4
    late = through("camera=delayed:0.2")
    assert late[:4] == [[]] * 4 and late[4] == [picture(1)]
    broken = [sent.jpeg for came in through("camera=garbage:0.05") for sent in came]
    assert all(jpeg != picture(i + 1).jpeg for i, jpeg in enumerate(broken))
