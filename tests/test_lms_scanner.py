# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated LMS200 answers as the protocol's description says, to the byte, and at the pace of its line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.drivers.lms2xx_messages import SPEEDS, parse_status
from edgefusion.drivers.lms2xx_scan import parse_scan, range_max_m, ranges_of
from edgefusion.drivers.lms2xx_telegram import TelegramReader, encode
from edgefusion.drivers.lms2xx_timing import stamped
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.types import Pose2D

MS = 1_000_000
ROOM = np.array([[3, -3, 3, 3], [3, 3, -3, 3], [-3, 3, -3, -3], [-3, -3, 3, -3]], float)
CLEAN = LaserSpec(sigma_m=0.0, dropped=0.0, mixed=0.0)
STATUS, TYPE, ERRORS, CONFIGURATION, RESET = b"\x31", b"\x3a", b"\x32", b"\x74", b"\x10"
STREAM, PARTIAL, ON_REQUEST, ONE = b"\x20\x24", b"\x20\x2a", b"\x20\x25", b"\x30\x01"
HALF_DEGREE = bytes.fromhex("3bb4003200")
INSTALL = b"\x20\x00SICK_LMS"


class Client:
    """On a scanner's line, in a time of its own that goes in milliseconds."""

    def __init__(self, baudrate: int = 9600, ranges=None, turn_radps: float = 0.0, **how) -> None:
        self.now_ns, self.baudrate = 0, baudrate
        self.turn_radps, self.ranges, self.room = turn_radps, ranges, ROOM
        self.scanner = LmsScanner(self.scan_at, 0, real=CLEAN, **how)
        self.reader = TelegramReader()
        self.heard = b""

    def pose_at(self, ns: int) -> Pose2D:
        return Pose2D(0.0, 0.0, math.remainder(self.turn_radps * ns / 1e9, 2 * math.pi))

    def scan_at(self, stamp_ns: int, spec: LaserSpec):
        scan = SimLaser(spec).scan(stamp_ns, self.room, self.pose_at, np.random.default_rng(0))[0]
        if self.ranges is not None:
            scan.ranges_m.setflags(write=True)
            scan.ranges_m[: len(self.ranges)] = self.ranges
        return scan

    def wait(self, ms: int) -> list:
        """What came meanwhile, and when it was whole [ms]."""
        found = []
        for _ in range(ms):
            self.now_ns += MS
            data = self.scanner.transmit(self.baudrate, self.now_ns)
            self.heard += data
            found += [(self.now_ns // MS, item) for item in self.reader.feed(data)]
        return found

    def say(self, telegram: bytes) -> None:
        self.scanner.receive(telegram, self.baudrate, self.now_ns)

    def ask(self, command: bytes, within_ms: int = 1200) -> bytes:
        """The payload of the answer to it."""
        self.say(encode(command))
        payloads = [item.payload for _, item in self.wait(within_ms) if item.handshake is None]
        wanted = [payload for payload in payloads if payload[0] in (command[0] | 0x80, 0x92)]
        assert len(wanted) == 1, payloads
        return wanted[0]

    def at(self, baudrate: int) -> Client:
        """The same after switching both ends."""
        self.ask(SPEEDS[baudrate])
        self.baudrate = baudrate
        return self

    def scans(self, ms: int) -> list:
        return [(at, item.payload) for at, item in self.wait(ms) if item.handshake is None and item.payload[0] == 0xB0]


def test_a_command_is_acknowledged_within_60_ms_and_then_answered() -> None:
    client = Client()
    client.say(bytes.fromhex("02000200202535 08".replace(" ", "")))  # on request
    came = client.wait(60)
    assert [item.handshake for _, item in came] == [0x06, None]
    assert client.heard == b"\x06" + bytes.fromhex("02800300a000") + b"\x10" + client.heard[-2:]
    assert client.heard.endswith(bytes.fromhex("02800300a00010160a"))


@pytest.mark.parametrize(
    ("command", "code", "size"), [(STATUS, 0xB1, 154), (TYPE, 0xBA, 23), (ERRORS, 0xB2, 2), (CONFIGURATION, 0xF4, 34)]
)
def test_it_tells_what_it_is(command: bytes, code: int, size: int) -> None:
    answer = Client().ask(command)
    assert answer[0] == code and len(answer) == size and answer[-1] == 0x10
    if command == TYPE:
        assert answer[1:].startswith(b"LMS200;301063;V")


def test_its_status_says_what_it_measures() -> None:
    client = Client()
    client.ask(HALF_DEGREE)
    status = parse_status(client.ask(STATUS))
    assert (status.measuring_mode, status.unit, status.variant) == (0, 1, (180, 50))


def test_broken_telegrams_are_refused_without_an_answer() -> None:
    client = Client()
    client.say(encode(STATUS)[:-1] + b"\x00")
    assert [item for _, item in client.wait(200) if item.handshake is None] == []
    assert client.ask(b"\x99")[0] == 0x92
    assert client.ask(b"\x20\x77")[0] == 0x92


@pytest.mark.parametrize("baudrate", [38400, 19200, 500000])
def test_a_new_speed_is_answered_at_the_old_one(baudrate: int) -> None:
    client = Client()
    assert client.ask(SPEEDS[baudrate]) == b"\xa0\x00\x10"
    client.say(encode(STATUS))  # at 9600 it is deaf now
    assert client.wait(500) == []
    client.baudrate = baudrate
    assert client.ask(STATUS)[0] == 0xB1


def test_what_it_says_at_another_speed_is_noise() -> None:
    client = Client(baudrate=9600, left_at=38400)
    assert client.wait(500) == [] and len(client.heard) > 1000
    client.baudrate = 38400
    assert len(client.scans(500)) >= 4


@pytest.mark.parametrize(
    ("baudrate", "variant", "count", "rate_hz"),
    [
        (38400, HALF_DEGREE, 361, 5.2),
        (38400, bytes.fromhex("3bb4006400"), 181, 10.3),
        (500000, HALF_DEGREE, 361, 37.5),
        (500000, bytes.fromhex("3bb4006400"), 181, 75.0),
        (500000, bytes.fromhex("3b64001900"), 401, 18.75),
    ],
)
def test_scans_come_as_fast_as_mirror_and_line_allow(baudrate, variant, count, rate_hz) -> None:
    client = Client().at(baudrate)
    assert client.ask(variant)[1] == 1
    client.ask(STREAM)
    scans = client.scans(4000)
    assert len(scans) / 4 == pytest.approx(rate_hz, rel=0.12)
    assert {len(parse_scan(payload).values) for _, payload in scans} == {count}


def test_partial_scans_come_with_every_turn_of_the_mirror() -> None:
    client = Client().at(500000)
    client.ask(HALF_DEGREE)
    client.ask(PARTIAL)
    raws = [parse_scan(payload) for _, payload in client.scans(1000)]
    assert len(raws) == pytest.approx(75, abs=2)
    assert {(raw.partial, raw.offset, len(raw.values)) for raw in raws} == {(True, 0, 181), (True, 2, 180)}
    assert [raw.offset for raw in raws[:4]] in ([0, 2, 0, 2], [2, 0, 2, 0])


def test_a_resolution_that_needs_another_angle_is_refused_and_the_old_stays() -> None:
    client = Client()
    assert client.ask(bytes.fromhex("3bb4001900")) == bytes.fromhex("bb00b400640010")


def test_setting_what_it_covers_stops_the_stream() -> None:
    client = Client(38400, left_at=38400)
    assert client.scans(400)
    client.ask(HALF_DEGREE)
    client.wait(200)
    assert client.scans(500) == []


def test_its_memory_is_written_in_installation_mode_only_and_takes_seconds() -> None:
    client = Client()
    block = bytearray(client.ask(CONFIGURATION)[1:-1])
    block[5:7] = bytes([4, 0])
    assert client.ask(b"\x77" + bytes(block))[:2] == b"\xf7\x00" and client.scanner.settings.written == 0
    assert client.ask(b"\x20\x00SICK_PLS") == b"\xa0\x01\x10"
    assert client.ask(INSTALL) == b"\xa0\x00\x10"
    client.say(encode(b"\x77" + bytes(block)))
    assert [item for _, item in client.wait(2900) if item.handshake is None] == []
    assert client.wait(500)[-1][1].payload[:2] == b"\xf7\x01" and client.scanner.settings.written == 1
    client.scanner.power_cycle(client.now_ns, 1.0)
    client.wait(2000)
    assert parse_status(client.ask(STATUS)).measuring_mode == 4


def test_power_on_is_said_at_9600_under_another_address_and_all_but_the_memory_is_forgotten() -> None:
    client = Client().at(38400)
    client.ask(HALF_DEGREE)
    client.scanner.power_cycle(client.now_ns, 5.0)
    client.baudrate = 9600
    client.say(encode(STATUS))
    assert client.wait(4900) == []
    client.heard = b""
    (_, item), *_ = client.wait(500)
    assert item.payload.startswith(b"\x90LMS200;301063;V") and client.heard[1] == 0x81
    assert parse_status(client.ask(STATUS)).variant == (180, 100)


def test_a_reset_is_answered_before_it_happens() -> None:
    client = Client()
    client.say(encode(RESET))
    payloads = [item.payload[0] for _, item in client.wait(8000) if item.handshake is None]
    assert payloads == [0x91, 0x90]


@pytest.mark.parametrize(("mode", "max_m"), [(0, 8.183), (3, 16.375), (6, 32.759)])
def test_what_is_too_far_and_what_is_unknown_have_their_values_in_every_mode(mode: int, max_m: float) -> None:
    client = Client(ranges=[math.inf, math.nan, 8.5, 1.234, 8.185])
    client.scanner.settings.block[5] = mode
    raw = parse_scan(client.ask(ONE))
    got = ranges_of(raw, mode)
    assert range_max_m(raw, mode) == pytest.approx(max_m)
    assert got[0] == math.inf and math.isnan(got[1]) and got[3] == pytest.approx(1.234)
    assert got[2] == (math.inf if mode == 0 else pytest.approx(8.5))
    assert got[4] == (math.inf if mode == 0 else pytest.approx(8.185))


def test_it_sees_as_far_as_its_mode_lets_it() -> None:
    client = Client()
    client.room = ROOM * 5
    client.scanner.settings.block[5] = 3
    assert ranges_of(parse_scan(client.ask(ONE)), 3)[90] == pytest.approx(15.0, abs=0.01)


def test_a_scan_in_centimetres_says_so() -> None:
    client = Client(ranges=[1.234])
    client.scanner.settings.block[6] = 0
    raw = parse_scan(client.ask(ONE))
    assert raw.unit_m == 0.01 and ranges_of(raw, 0)[0] == pytest.approx(1.23)


def test_real_time_indices_are_skipped_by_our_reader() -> None:
    client = Client()
    client.scanner.settings.block[4] |= 0x02
    payload = client.ask(ONE)
    assert len(payload) == 1 + 2 + 2 * 181 + 2 and len(parse_scan(payload).values) == 181


def test_dirt_and_dazzle_show_in_the_last_byte_of_everything() -> None:
    client = Client()
    client.scanner.status_byte = 0x10 | 0x80 | 0x40
    assert client.ask(ONE)[-1] == client.ask(STATUS)[-1] == 0xD0


@pytest.mark.parametrize("turn_radps", [0.0, math.radians(100), -math.radians(100)])
def test_a_scan_is_what_was_there_when_our_driver_says_it_was_measured(turn_radps: float) -> None:
    client = Client(turn_radps=turn_radps).at(500000)
    client.ask(HALF_DEGREE)
    client.ask(STREAM)
    client.wait(100)
    at, payload = client.scans(60)[0]
    line_ns = (len(payload) + 6) * 10 * 1_000_000_000 // 500000
    scan = stamped(parse_scan(payload), 0, at * MS - line_ns)
    truth = SimLaser(CLEAN).scan(scan.stamp_ns, ROOM, client.pose_at, np.random.default_rng(0))[0]
    # The time is read in whole milliseconds here: 0.1 degree.
    assert np.abs(scan.ranges_m - truth.ranges_m).max() < 0.02
