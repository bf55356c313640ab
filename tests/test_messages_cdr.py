# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Messages as bytes and back, and bytes that are no messages."""

from __future__ import annotations

import struct
import threading
import tracemalloc

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from any_message import any_message, meaning
from edgefusion.errors import RefusedError
from edgefusion.messages.builtin_interfaces import Time
from edgefusion.messages.cdr import MOST_BYTES, WireError, decode, encode
from edgefusion.messages.geometry_msgs import Point, Pose, PoseStamped, PoseWithCovariance, Quaternion
from edgefusion.messages.idl import Message
from edgefusion.messages.registry import MESSAGES
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage, LaserScan, RegionOfInterest
from edgefusion.messages.std_msgs import Header, String
from edgefusion.messages.visualization_msgs import Marker, MarkerArray

LITTLE, BIG = bytes([0, 1, 0, 0]), bytes(4)
GOAL = PoseStamped(Header(Time(12, 34), "odom"), Pose(Point(5.0, 5.5), Quaternion(0.0, 0.0, 0.6, 0.8)))
SCAN = LaserScan(Header(Time(1, 2), "laser"), angle_increment=0.5, ranges=[1.5, 2.5, float("inf")])

every_type = pytest.mark.parametrize("name", sorted(MESSAGES))


def refusal(cls: type[Message], data: bytes) -> str:
    with pytest.raises(WireError) as caught:
        decode(cls, data)
    return str(caught.value)


def reads_or_refuses(cls: type[Message], data: bytes) -> None:
    try:
        message = decode(cls, data)
    except WireError as error:
        assert str(error).startswith(f"{cls.__idl_typename__}: ") and "\n" not in str(error)
    else:
        assert isinstance(message, cls)


def test_a_text_is_its_length_its_bytes_and_a_zero() -> None:
    assert encode(String("ä")) == LITTLE + b"\x03\x00\x00\x00\xc3\xa4\x00"
    assert decode(String, BIG + b"\x00\x00\x00\x03\xc3\xa4\x00") == String("ä")


def test_alignment_counts_from_behind_the_header() -> None:
    assert encode(GOAL) == LITTLE + struct.pack("<iII5s7x7d", 12, 34, 5, b"odom", 5.0, 5.5, 0.0, 0.0, 0.0, 0.6, 0.8)


@every_type
@settings(max_examples=15)
@given(data=st.data())
def test_what_is_written_is_read_back(name: str, data: st.DataObject) -> None:
    written = encode(data.draw(any_message(MESSAGES[name])))
    assert encode(decode(MESSAGES[name], written)) == written


def test_messages_compare_by_what_is_in_them() -> None:
    assert decode(LaserScan, encode(SCAN)) == SCAN
    assert decode(LaserScan, encode(SCAN)) != LaserScan()


@every_type
@settings(max_examples=12)
@given(header=st.sampled_from([LITTLE, BIG, b""]), body=st.binary(max_size=300))
def test_any_bytes_are_a_message_or_refused(name: str, header: bytes, body: bytes) -> None:
    reads_or_refuses(MESSAGES[name], header + body)


@every_type
@settings(max_examples=12)
@given(data=st.data())
def test_a_message_with_a_byte_changed_is_a_message_or_refused(name: str, data: st.DataObject) -> None:
    written = bytearray(encode(data.draw(any_message(MESSAGES[name]))))
    written[data.draw(st.integers(0, len(written) - 1))] = data.draw(st.integers(0, 255))
    reads_or_refuses(MESSAGES[name], bytes(written))


@every_type
@settings(max_examples=10)
@given(data=st.data())
def test_a_message_cut_anywhere_is_refused(name: str, data: st.DataObject) -> None:
    written = encode(data.draw(any_message(MESSAGES[name])))
    refusal(MESSAGES[name], written[: data.draw(st.integers(0, len(written) - 1))])


def test_a_refusal_says_of_what_type_what_was_expected_and_where() -> None:
    assert refusal(PoseStamped, encode(GOAL)[:-3]) == "geometry_msgs/msg/PoseStamped: expected 8 bytes at 76, got 5"
    assert issubclass(WireError, RefusedError)


def test_what_somebody_sent_makes_no_second_line_and_no_long_one() -> None:
    assert str(WireError("a\nb\x1b\u2028ä")) == "a\\nb\\x1b\\u2028ä"
    assert len(str(WireError("x" * 100_000))) == 400


def test_what_follows_a_message_is_refused() -> None:
    written = encode(GOAL)
    for garbage in (b"\x01", b"\x00\x00\x00\x01", bytes(4), bytes(1000)):
        assert "expected the end at 84" in refusal(PoseStamped, written + garbage)


def test_zeros_up_to_a_whole_word_may_follow_as_some_writers_pad() -> None:
    written = encode(String("ab"))  # 4 + 4 + 3 bytes
    assert decode(String, written + b"\x00") == String("ab")
    for padding in (b"\x01", b"\x00\x00", bytes(5)):
        assert "expected the end" in refusal(String, written + padding)
    assert "expected the end" in refusal(String, encode(String("")) + b"\x00")  # 4 + 4 + 1: not yet a word


def test_the_options_in_the_header_say_nothing_that_matters() -> None:
    assert decode(String, b"\x00\x01\x00\x01" + encode(String("ab"))[4:] + b"\x00") == String("ab")


@pytest.mark.parametrize("kind", [b"\x00\x02", b"\x00\x03", b"\x00\x06", b"\x00\x07", b"\x00\x0b", b"\x01\x01"])
def test_other_encodings_than_plain_cdr_are_refused(kind: bytes) -> None:
    assert f"expected plain CDR, 0000 or 0001, got {kind.hex()}" in refusal(String, kind + encode(String())[2:])


def test_what_is_longer_than_any_message_is_refused_unread() -> None:
    assert f"got {MOST_BYTES + 1}" in refusal(String, bytes(MOST_BYTES + 1))


@pytest.mark.parametrize("length", [0x7FFFFFFF, 0x80000000, 0xFFFFFFFF])
@pytest.mark.parametrize("cls", [LaserScan, CompressedImage, CameraInfo, MarkerArray, String])
def test_a_huge_length_allocates_nothing(cls: type[Message], length: int) -> None:
    written = encode(cls())
    # Every place where a length may stand, and whatever else stands there.
    lies = [written[:at] + struct.pack("<I", length) + written[at + 4 :] for at in range(4, len(written) - 4, 4)]
    lies += [LITTLE + struct.pack("<I", length), written[:4] + struct.pack("<I", length) + bytes(64)]
    tracemalloc.start()
    try:
        for lie in lies:
            reads_or_refuses(cls, lie)
        assert tracemalloc.get_traced_memory()[1] < 200_000
    finally:
        tracemalloc.stop()


def test_a_text_that_is_no_utf_8_or_does_not_end_with_zero_is_refused() -> None:
    assert "utf-8" in refusal(String, LITTLE + b"\x03\x00\x00\x00\xff\xff\x00")
    assert "expected a text to end with 0 at 10, got 200" in refusal(String, LITTLE + b"\x03\x00\x00\x00ab\xc8")
    assert "expected -1 bytes" in refusal(String, LITTLE + bytes(4))


def test_a_truth_value_is_zero_or_one() -> None:
    written = encode(RegionOfInterest(do_rectify=True))
    assert decode(RegionOfInterest, written).do_rectify is True
    assert "expected 0 or 1 at 20, got 2" in refusal(RegionOfInterest, written[:-1] + b"\x02")


def test_no_message_has_an_int8_which_the_end_of_a_text_is_read_as() -> None:
    kinds = {meaning(kind) for cls in MESSAGES.values() for kind in cls.__annotations__.values()}
    assert not kinds & {"int8", "char"}


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (Time(sec=2**31), "sec"),
        (Time(sec=1.5), "sec"),
        (LaserScan(range_max=1e39), "range_max"),
        (LaserScan(ranges=["near"]), "ranges"),
        (PoseWithCovariance(covariance=[0.0] * 35), "covariance"),
        (Header(frame_id="\ud800"), "frame_id"),
        (PoseStamped(header=Header(Time(nanosec=-1))), "header.stamp.nanosec"),
        (MarkerArray([Marker(), None]), "markers"),
    ],
)
def test_a_value_that_its_field_cannot_hold_is_refused_by_name(message: Message, reason: str) -> None:
    with pytest.raises(WireError) as caught:
        encode(message)
    assert str(caught.value).startswith(f"{message.__idl_typename__}: {reason}: ")
    assert "\n" not in str(caught.value)


def test_several_threads_write_and_read_at_once() -> None:
    expected = {encode(GOAL), encode(SCAN)}
    found: set[bytes] = set()

    def work(message: Message) -> None:
        for _ in range(200):
            found.add(encode(decode(type(message), encode(message))))

    threads = [threading.Thread(target=work, args=(message,)) for message in (GOAL, SCAN) * 2]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == expected
