# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What clients that others wrote say to an LMS200, in their order and timing, and what they need to hear for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.drivers.lms2xx_telegram import TelegramReader, crc16, encode
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.types import Scan

MS = 1_000_000
OK = bytes.fromhex("02800300a00010160a")
INSTALL = bytes.fromhex("02000a002000534943 4b5f4c4d53bec5".replace(" ", ""))


class Client:
    """At the far end of a scanner's line; every beam i of a scan has a range of 1 m + i mm."""

    def __init__(self, **how) -> None:
        self.now_ns, self.baudrate = 0, 9600
        self.scanner = LmsScanner(self.scan_at, 0, **how)
        self.stamps: list[int] = []

    def scan_at(self, stamp_ns: int, spec: LaserSpec) -> Scan:
        self.stamps.append(stamp_ns)
        ranges_m = (1 + np.arange(spec.beams) / 1000).astype(np.float32)
        return Scan(stamp_ns, ranges_m, spec.angle_min, spec.angle_increment)

    def wait(self, ms: int) -> bytes:
        heard = b""
        for _ in range(ms):
            self.now_ns += MS
            heard += self.scanner.transmit(self.baudrate, self.now_ns)
        return heard

    def say(self, telegram: bytes, wait_ms: int = 60) -> bytes:
        self.scanner.receive(telegram, self.baudrate, self.now_ns)
        return self.wait(wait_ms)

    def answer(self, payload: bytes, wait_ms: int = 200) -> bytes:
        """The payload of the first telegram after the ACK."""
        heard = self.say(encode(payload), wait_ms)
        return next(item.payload for item in TelegramReader().feed(heard) if item.handshake is None)

    def session(self, baudrate: int = 38400) -> Client:
        """The same at that speed."""
        self.answer({38400: b"\x20\x40", 500000: b"\x20\x48"}[baudrate])
        self.baudrate = baudrate
        return self

    def telegrams(self, ms: int) -> list[bytes]:
        return [item.payload for item in TelegramReader().feed(self.wait(ms)) if item.handshake is None]


@pytest.mark.parametrize(
    ("telegram", "reply"),
    [
        ("02000100311512", 0xB1),
        ("02000100321612", 0xB2),
        ("020001003a1e12", 0xBA),
        ("02000100103412", 0x91),
        ("02000100745012", 0xF4),
        ("0200020030013118", 0xB0),
        ("0200020020405008", 0xA0),
        ("0200020020415108", 0xA0),
        ("0200020020425208", 0xA0),
        ("0200020020485808", 0xA0),
        ("0200020020243408", 0xA0),
        ("0200020020253508", 0xA0),
        ("020005003bb40064009749", 0xBB),
        ("020005003bb40032003b1f", 0xBB),
        ("020005003b640064001d0f", 0xBB),
        ("020005003b64003200b159", 0xBB),
        ("020005003b64001900e772", 0xBB),
    ],
)
def test_every_published_telegram_is_acknowledged_and_answered(telegram: str, reply: int) -> None:
    heard = Client().say(bytes.fromhex(telegram), 1000)
    assert heard[:3] == b"\x06\x02\x80" and heard[5] == reply


def test_it_begins_as_the_published_one() -> None:
    published = bytes.fromhex("02811700904c4d533230303b3330313036333b5630322e303620136 45a".replace(" ", ""))
    assert crc16(published[:-2]).to_bytes(2, "little") == published[-2:]
    heard = Client(power_up_s=1.0).wait(1100)
    assert heard[:19] == published[:19] and len(heard) == len(published)


def test_mode_ok_is_said_as_published() -> None:
    assert Client().say(INSTALL) == b"\x06" + OK


@pytest.mark.parametrize("spoil", [-1, 4, 5])
def test_a_telegram_that_came_broken_is_refused_at_once_and_heard_when_it_comes_again(spoil: int) -> None:
    client, broken = Client(), bytearray.fromhex("0200020020405008")
    broken[spoil] ^= 0x10
    assert client.say(bytes(broken)) == b"\x15"
    assert client.say(bytes.fromhex("0200020020405008")) == b"\x06" + OK


def test_a_length_that_no_telegram_has_is_refused() -> None:
    assert Client().say(b"\x02\x00\xff\x0f\x20") == b"\x15"


def test_bytes_may_come_one_by_one_but_not_seconds_apart() -> None:
    client, telegram = Client(), bytes.fromhex("02000100311512")
    client.wait(500)
    assert b"".join(client.say(telegram[at : at + 1], 1) for at in range(7)) + client.wait(300)
    assert client.say(telegram[:4], 200) == b""
    assert client.say(telegram)[:3] == b"\x06\x02\x80"


def test_noise_before_a_telegram_is_not_heard() -> None:
    assert Client().say(b"\x00\xff\x55" + bytes.fromhex("0200020020253508")) == b"\x06" + OK


@given(st.lists(st.tuples(st.binary(max_size=40), st.integers(0, 200)), max_size=12))
def test_whatever_a_client_says_it_goes_on(chunks: list[tuple[bytes, int]]) -> None:
    client = Client()
    for data, wait_ms in chunks:
        client.say(data, wait_ms)
    client.wait(5500)  # it may have been told to begin anew
    client.baudrate = client.scanner.line.baudrate
    assert client.answer(b"\x31", 2000)[0] in (0xB0, 0xB1, 0xB6, 0xB7)


@given(st.binary(min_size=1, max_size=40))
def test_every_telegram_is_answered_once(payload: bytes) -> None:
    heard = TelegramReader().feed(Client().say(encode(payload), 5000))
    assert [item.handshake for item in heard[:2]] == [0x06, None]


def test_aria_sets_its_speed_without_hearing_then_variant_memory_and_stream() -> None:
    client = Client()
    client.say(encode(b"\x20\x40"), 20)
    client.baudrate = 38400
    client.wait(300)
    assert client.answer(b"\x3b\xb4\x00\x32\x00")[:2] == b"\xbb\x01"
    assert client.answer(b"\x20\x00SICK_LMS")[:2] == b"\xa0\x00"
    block = bytes([0, 0, 70, 0, 0, 5, 1, 0, 0, 2, 2]) + bytes(21)
    assert client.answer(b"\x77" + block, 14000)[:2] == b"\xf7\x01"
    assert client.answer(b"\x20\x24")[:2] == b"\xa0\x00"
    scans = client.telegrams(2000)
    assert 10 <= len(scans) <= 11 and {scan[:3] for scan in scans} == {bytes.fromhex("b06941")}
    assert scans[0][3:5] == (1000).to_bytes(2, "little")


def test_sicktoolbox_sends_34_bytes_of_memory_and_reads_it_back_in_the_status() -> None:
    client = Client()
    assert b"LMS200;30106" in client.answer(b"\x3a")
    block = bytearray(client.answer(b"\x74")[1:] + bytes(2))[:34]
    block[5], block[6] = 0x03, 0x00
    assert client.answer(b"\x20\x00SICK_LMS")[1] == 0
    reply = client.answer(b"\x77" + bytes(block), 15000)
    assert reply[:2] == b"\xf7\x01" and reply[2 + 5 : 2 + 7] == b"\x03\x00"
    assert client.answer(b"\x20\x25")[1] == 0
    status = client.answer(b"\x31", 400)
    assert len(status) == 1 + 152 + 1
    assert (status[8], status[102], status[122], status[1:8]) == (0x25, 3, 0, b"V02.10 ")
    assert (status[18], status[67:69], status[116:118]) == (180, b"\x4b\x00", b"\x67\x80")
    assert len(client.answer(b"\x74")) == 1 + 32 + 1


def test_player_sends_the_begin_of_the_memory_and_asks_for_a_range_of_beams() -> None:
    client = Client().session()
    assert client.answer(b"\x20\x00SICK_LMS")[1] == 0
    assert client.answer(b"\x77" + bytes([0, 0, 70, 0, 1, 1, 1]), 10000)[1] == 1
    assert client.answer(b"\x74")[1:8] == bytes([0, 0, 70, 0, 1, 1, 1])
    assert client.answer(b"\x20\x27\x0b\x00\x5b\x00")[:2] == b"\xa0\x00"
    said = client.telegrams(500)[0]
    assert said[:7] == bytes.fromhex("b70b005b005140") and len(said) == 7 + 2 * 81 + 1
    assert int.from_bytes(said[7:9], "little") == 1010


def test_mrpt_asks_again_while_the_memory_is_being_written() -> None:
    client = Client().session()
    block = bytearray(client.answer(b"\x74")[1:-1] + bytes(2))
    block[5] = 6
    for attempt in range(2):
        assert client.answer(b"\x20\x00SICK_LMS")[:2] == b"\xa0\x00"
        heard = TelegramReader().feed(client.say(encode(b"\x77" + bytes(block)), 600))
        assert [item.payload[0] for item in heard] == [0x06, 0xF7][: attempt + 1]


@pytest.mark.parametrize("ahead_ms", range(0, 28, 3))
def test_a_stream_begins_behind_its_answer(ahead_ms: int) -> None:
    client = Client().session(500000)
    client.wait(ahead_ms)
    came = TelegramReader().feed(client.say(encode(b"\x20\x24"), 100))
    assert [item.payload[0] for item in came[:3]] == [0x06, 0xA0, 0xB0]


def test_a_wrong_password_changes_nothing() -> None:
    client = Client().session()
    client.answer(b"\x20\x24")
    assert client.say(encode(b"\x20\x00SICK_PLS"), 400).count(b"\xa0\x01\x10") == 1
    assert client.scanner.streaming


def test_a_stream_pauses_while_the_speed_changes() -> None:
    client = Client(left_at=38400)
    client.baudrate = 38400
    client.wait(500)
    said = [item.payload[0] for item in TelegramReader().feed(client.say(encode(b"\x20\x48"), 400))]
    assert said[-1:] == [0xA0]
    client.baudrate = 500000
    assert len(client.telegrams(100)) >= 6


def test_at_another_speed_it_is_deaf() -> None:
    client = Client().session()
    client.baudrate = 9600
    client.say(encode(b"\x20\x24"))
    assert not client.scanner.streaming


def test_what_has_not_left_is_lost_with_the_power() -> None:
    client = Client()
    client.say(encode(b"\x31"), 30)
    client.scanner.power_cycle(client.now_ns, 0.5)
    assert client.wait(1000)[:5] == b"\x02\x81\x17\x00\x90"


@pytest.mark.parametrize("asks", [False, True])
def test_over_a_slow_line_the_scans_do_not_get_older(asks: bool) -> None:
    client, reader, came_ns = Client(left_at=38400), TelegramReader(), []
    client.baudrate = 38400
    for ms in range(4000):
        if asks and ms % 100 == 0:
            client.scanner.receive(encode(b"\x31"), 38400, client.now_ns)
        came_ns += [client.now_ns for item in reader.feed(client.wait(1)) if item.payload[0] == 0xB0]
    ages_ms = [(came - stamp) / MS for came, stamp in zip(came_ns, client.stamps)]
    # A turn of the mirror until it is complete, another until it is the newest, and its way over the line.
    assert len(ages_ms) > 20 and max(ages_ms) < 13.4 + 13.4 + 96.9 + 2


def test_a_turn_of_the_mirror_is_the_one_that_a_whole_scan_is_woven_from() -> None:
    client = Client().session(500000)
    client.answer(b"\x3b\xb4\x00\x32\x00")
    client.answer(b"\x20\x2a")
    client.telegrams(100)
    client.stamps.clear()
    offsets = [said[2] >> 3 & 3 for said in client.telegrams(200)]
    ends = [round((ns + 13_333_333 / 4) / 13_333_333) for ns in client.stamps]  # the middle is a quarter before the end
    assert set(offsets) == {0, 2} and all((end % 2 == 0) == (offset == 2) for end, offset in zip(ends, offsets))


def test_a_scan_that_is_asked_for_is_the_newest_whole_one() -> None:
    client = Client()
    client.wait(400)
    stamps = []
    for _ in range(40):
        client.say(encode(b"\x30\x01"), 1)
        stamps.append(client.stamps[-1])
    assert len(set(stamps)) in (3, 4, 5)


def test_only_whole_scans_can_be_asked_for_one_by_one() -> None:
    assert Client().answer(b"\x30\x02") == b"\x92\x10"


def test_a_stream_counts_the_mirrors_turns_where_that_is_wanted() -> None:
    client = Client().session(500000)
    client.scanner.settings.block[4] = 0x02
    client.answer(b"\x20\x24")
    indices = [said[-2] for said in client.telegrams(200) if len(said) == 3 + 2 * 181 + 2]
    assert len(indices) > 10 and {(b - a) % 256 for a, b in zip(indices, indices[1:])} == {1}


def test_means_come_when_all_their_scans_are_there() -> None:
    client = Client().session(500000)
    assert client.answer(b"\x20\x26\x05")[:2] == b"\xa0\x00"
    client.telegrams(200)
    client.stamps.clear()
    said = client.telegrams(1000)
    assert len(said) == pytest.approx(75 / 5, abs=1)
    assert said[0][:4] == bytes.fromhex("b605b540") and len(said[0]) == 4 + 2 * 181 + 1
    assert len(client.stamps) == len(set(client.stamps)) == 5 * len(said)


@pytest.mark.parametrize("mode", ["2601", "26ff", "2700000100", "270200b600", "2705000400", "2400", "50010001b5", "7f"])
def test_modes_that_it_has_not_are_refused_and_leave_the_old_one(mode: str) -> None:
    client = Client()
    assert client.answer(b"\x20" + bytes.fromhex(mode)) == b"\x92\x10"
    assert client.wait(500) == b"" and not client.scanner.streaming


@pytest.mark.parametrize("changed", [{5: 0x0F}, {5: 0x3F}, {6: 3}])
def test_measuring_modes_and_units_that_it_has_not_are_not_written(changed: dict) -> None:
    client = Client()
    block = bytearray(client.answer(b"\x74")[1:-1])
    before = bytes(block)
    for at, value in changed.items():
        block[at] = value
    client.answer(b"\x20\x00SICK_LMS")
    assert client.answer(b"\x77" + bytes(block), 4000)[1] == 0
    assert client.answer(b"\x77" + before[:6], 4000)[1] == 0
    assert client.answer(b"\x74")[1:-1] == before and client.scanner.settings.written == 0


@pytest.mark.parametrize(("unit", "first"), [(0, 100), (1, 1000), (2, 10)])
def test_a_scan_is_in_the_unit_that_it_names(unit: int, first: int) -> None:
    client = Client()
    client.scanner.settings.block[6] = unit
    said = client.answer(b"\x30\x01", 1000)
    assert said[2] >> 6 == unit and int.from_bytes(said[3:5], "little") == first


@pytest.mark.parametrize(("status", "value"), [(0x10, 8191), (0x50, 8190)])
def test_a_dazzled_laser_says_so_in_its_values(status: int, value: int) -> None:
    client = Client()
    client.scanner.covered, client.scanner.status_byte = True, status
    said = client.answer(b"\x30\x01", 1000)
    assert int.from_bytes(said[3:5], "little") == value and said[-1] == status
