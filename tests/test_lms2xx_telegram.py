# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Telegrams of the LMS2xx: the documented bytes, found in any pieces and behind any garbage."""

from __future__ import annotations

import random

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from edgefusion.drivers.lms2xx_telegram import (
    ACK,
    MAX_TELEGRAM_BYTES,
    NAK,
    STX,
    TO_LASER,
    Received,
    TelegramReader,
    crc16,
    encode,
)
from edgefusion.errors import RefusedError

VECTORS = {
    "31": "02 00 01 00 31 15 12",
    "32": "02 00 01 00 32 16 12",
    "3A": "02 00 01 00 3A 1E 12",
    "10": "02 00 01 00 10 34 12",
    "74": "02 00 01 00 74 50 12",
    "30 01": "02 00 02 00 30 01 31 18",
    "20 40": "02 00 02 00 20 40 50 08",
    "20 41": "02 00 02 00 20 41 51 08",
    "20 42": "02 00 02 00 20 42 52 08",
    "20 48": "02 00 02 00 20 48 58 08",
    "20 24": "02 00 02 00 20 24 34 08",
    "20 25": "02 00 02 00 20 25 35 08",
    "20 00 53 49 43 4B 5F 4C 4D 53": "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5",
    "3B B4 00 64 00": "02 00 05 00 3B B4 00 64 00 97 49",
    "3B B4 00 32 00": "02 00 05 00 3B B4 00 32 00 3B 1F",
    "3B 64 00 64 00": "02 00 05 00 3B 64 00 64 00 1D 0F",
    "3B 64 00 32 00": "02 00 05 00 3B 64 00 32 00 B1 59",
    "3B 64 00 19 00": "02 00 05 00 3B 64 00 19 00 E7 72",
}
MODE_OK = bytes.fromhex("02 80 03 00 A0 00 10 16 0A")
PAYLOADS = st.binary(min_size=1, max_size=MAX_TELEGRAM_BYTES - 6)
# Bytes that mean something are much more frequent than in noise.
MEAN_BYTES = st.lists(st.sampled_from([STX, 0x80, 0x81, 0x00, 0x01, 0x03, ACK, NAK, 0xFF]), max_size=200).map(bytes)


def payloads(found: list[Received]) -> list[bytes]:
    return [item.payload for item in found if item.handshake is None]


def all_of(stream: bytes) -> list[bytes]:
    reader = TelegramReader()
    return payloads(reader.feed(stream) + reader.silence())


@pytest.mark.parametrize(("payload", "telegram"), VECTORS.items())
def test_the_documented_commands_have_their_documented_bytes(payload: str, telegram: str) -> None:
    assert encode(bytes.fromhex(payload)) == bytes.fromhex(telegram)


def test_the_documented_reply_is_read_and_made() -> None:
    (received,) = TelegramReader().feed(MODE_OK)
    assert (received.address, received.payload) == (0x80, b"\xa0\x00\x10")
    assert encode(b"\xa0\x00\x10", 0x80) == MODE_OK


@pytest.mark.parametrize("size", [0, MAX_TELEGRAM_BYTES - 5])
def test_a_payload_that_no_telegram_can_hold_is_refused(size: int) -> None:
    with pytest.raises(RefusedError, match=f"payload: expected 1 to 806 bytes, got {size}"):
        encode(bytes(size))


def test_an_address_of_more_than_a_byte_is_refused() -> None:
    with pytest.raises(RefusedError, match="address: expected 0 to 255, got 256"):
        encode(b"1", 256)


@given(st.lists(PAYLOADS, max_size=5), st.randoms(use_true_random=False))
def test_telegrams_are_found_in_any_pieces(sent: list[bytes], rng: random.Random) -> None:
    stream, reader, found = b"".join(encode(payload, 0x80) for payload in sent), TelegramReader(), []
    while stream:
        piece = rng.randint(0, 50)
        found += reader.feed(stream[:piece])
        stream = stream[piece:]
    assert payloads(found) == sent
    assert reader.discarded_bytes == reader.pending_bytes == 0


@given(st.lists(st.tuples(MEAN_BYTES, PAYLOADS), max_size=4))
@example([(b"\x02\x80\x26\x03", b"a"), (b"", b"b")])
@example([(b"\x02", b"a"), (b"\x02\x80", b"b"), (b"\x02\x80\x05", b"c")])
def test_telegrams_are_found_behind_garbage_and_false_headers(sent: list[tuple[bytes, bytes]]) -> None:
    found = all_of(b"".join(noise + encode(payload, 0x80) for noise, payload in sent))
    wanted = [payload for _, payload in sent]
    assert [payload for payload in found if payload in wanted] == wanted


@given(st.lists(st.one_of(MEAN_BYTES, st.binary(max_size=2000)), max_size=10))
def test_any_bytes_are_all_accounted_for_in_a_buffer_of_one_telegram(pieces: list[bytes]) -> None:
    reader, read = TelegramReader(), 0
    for piece in pieces:
        read += sum(item.end - item.begin for item in reader.feed(piece))
        assert reader.pending_bytes < MAX_TELEGRAM_BYTES
    read += sum(item.end - item.begin for item in reader.silence())
    assert reader.pending_bytes == 0
    assert read + reader.discarded_bytes == reader.received_bytes == sum(map(len, pieces))


@given(
    st.lists(st.one_of(MEAN_BYTES, PAYLOADS.map(lambda payload: encode(payload, 0x80))), max_size=5),
    st.integers(0, 5),
    st.randoms(use_true_random=False),
)
def test_damaged_telegrams_say_the_same_in_any_pieces(parts: list[bytes], errors: int, rng: random.Random) -> None:
    stream = bytearray(b"".join(parts))
    for _ in range(errors if stream else 0):
        stream[rng.randrange(len(stream))] = rng.choice([STX, 0x80, 0x03, rng.randrange(256)])
    whole, reader, found = TelegramReader(), TelegramReader(), []
    expected = whole.feed(bytes(stream)) + whole.silence()
    while stream:
        size = rng.randint(1, 300)
        found += reader.feed(bytes(stream[:size]))
        del stream[:size]
    assert found + reader.silence() == expected
    assert reader.discarded_bytes == whole.discarded_bytes


@pytest.mark.parametrize("error_rate", [0.0001, 0.001, 0.003])
def test_all_but_a_hundredth_of_the_intact_telegrams_survive_errors_around_them(error_rate: float) -> None:
    rng = random.Random(7)
    intact, stream = [], b""
    for i in range(400):
        telegram = bytearray(
            encode(b"\xb0" + i.to_bytes(2, "big") + bytes(rng.randrange(256) for _ in range(723)), 0x80)
        )
        wrong = [at for at in range(len(telegram)) if rng.random() < error_rate]
        for at in wrong:
            telegram[at] ^= rng.randint(1, 255)
        intact += [bytes(telegram[4:-2])] * (not wrong)
        stream += telegram
    found = all_of(stream)
    assert len(intact) > 20
    assert len(set(found) & set(intact)) >= 0.99 * len(intact)
    assert len(set(found) - set(intact)) <= 1


@given(PAYLOADS, st.data())
def test_a_telegram_with_one_wrong_byte_is_no_telegram(payload: bytes, data: st.DataObject) -> None:
    telegram = bytearray(encode(payload, 0x80))
    at = data.draw(st.integers(0, len(telegram) - 1))
    telegram[at] ^= data.draw(st.integers(1, 255))
    if not (at == 1 and telegram[1] in range(0x80, 0x85)):
        assert payload not in all_of(bytes(telegram))


def test_ack_and_nak_count_between_telegrams_only() -> None:
    reader = TelegramReader()
    found = reader.feed(bytes([ACK]) + MODE_OK + bytes([NAK]) + encode(bytes([0xB0, ACK, NAK]), 0x80))
    assert [item.handshake for item in found] == [ACK, None, NAK, None]


def test_ack_and_nak_in_garbage_say_nothing_until_the_line_was_silent() -> None:
    reader = TelegramReader()
    assert reader.feed(bytes([0xFF, ACK, 0xFF, NAK])) == []
    assert reader.silence() == []
    assert [item.handshake for item in reader.feed(bytes([NAK]))] == [NAK]


def test_what_a_false_header_hides_comes_out_when_the_line_falls_silent() -> None:
    reader = TelegramReader()
    assert reader.feed(b"\x02\x80\x26\x03" + MODE_OK) == []
    assert payloads(reader.silence()) == [b"\xa0\x00\x10"]


def test_places_count_from_the_first_byte_of_the_stream() -> None:
    reader = TelegramReader()
    reader.feed(b"\xff" * 5 + MODE_OK[:4])
    (received,) = reader.feed(MODE_OK[4:] + b"\xff\x02")
    assert (received.begin, received.end, reader.received_bytes) == (5, 14, 16)


def test_power_on_telegrams_have_an_address_of_their_own_and_commands_are_not_replies() -> None:
    assert [item.address for item in TelegramReader().feed(encode(b"\x90LMS200", 0x81))] == [0x81]
    assert all_of(encode(b"\x31")) == []
    assert payloads(TelegramReader(TO_LASER).feed(encode(b"\x31"))) == [b"\x31"]


def test_the_checksum_of_nothing_is_zero() -> None:
    assert crc16(b"") == 0


def crc_bit_by_bit(data: bytes) -> int:
    """As it is documented."""
    crc, before = 0, 0
    for byte in data:
        crc = ((crc & 0x7FFF) << 1) ^ 0x8005 if crc & 0x8000 else crc << 1
        crc ^= byte | before << 8
        before = byte
    return crc


@given(st.binary(max_size=MAX_TELEGRAM_BYTES))
@example(b"\xff" * MAX_TELEGRAM_BYTES)
def test_the_checksum_is_the_documented_one(data: bytes) -> None:
    assert crc16(data) == crc_bit_by_bit(data)


def test_who_reads_what_is_wanted_ends_with_the_telegram() -> None:
    reader, stream, steps = TelegramReader(), MODE_OK * 2, []
    while len(steps) < 6:
        steps.append(reader.wanted_bytes)
        reader.feed(stream[: steps[-1]])
        stream = stream[steps[-1] :]
    assert steps == [1, 3, 5, 1, 3, 5]
    assert stream == b""


def test_in_garbage_more_than_a_byte_is_wanted_until_a_telegram_begins() -> None:
    reader = TelegramReader()
    reader.feed(b"\xff" * 3)
    assert reader.wanted_bytes > 10
    reader.feed(MODE_OK[:4])
    assert reader.wanted_bytes == 5
    reader.feed(MODE_OK[4:])
    assert reader.wanted_bytes == 1
