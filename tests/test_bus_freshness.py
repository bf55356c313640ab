# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which commands count: the newer of each sender, in time, not too large and not too many."""

from __future__ import annotations

from typing import List, Optional

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.bus.freshness import MOST_SESSIONS, CommandLimits, Freshness, Refusal, limits_of
from edgefusion.bus.rate_limit import RateLimit
from edgefusion.bus.tags import MOST_BYTES, CommandTag, SampleTag, Tagger, read_tag, session_of
from edgefusion.config.bus import BusConfig
from edgefusion.errors import RefusedError

MS = 1_000_000
LIMITS = CommandLimits(max_bytes=4096, max_hz=50)
MANY = CommandLimits(max_bytes=4096, max_hz=1e6, burst=10_000_000)


def tag(seq: int, session: str = "a", ttl_ms: int = 200) -> bytes:
    return msgspec.json.encode(CommandTag(session, seq, ttl_ms))


def judge(freshness: Freshness, attachment: Optional[bytes], age_ms: float = 0, now_ms: float = 0) -> Optional[Refusal]:
    now_ns = round(now_ms * MS)
    return freshness.judge(now_ns, now_ns - round(age_ms * MS), 100, attachment)


def test_a_command_counts_once() -> None:
    freshness = Freshness(LIMITS)
    assert judge(freshness, tag(0)) is None
    assert judge(freshness, tag(0)) is Refusal.REPLAYED
    assert judge(freshness, tag(1)) is None
    assert (freshness.accepted, freshness.counts) == (2, {Refusal.REPLAYED: 1})


@given(st.lists(st.integers(0, 30), max_size=40))
def test_only_a_number_above_all_before_it_counts(numbers: List[int]) -> None:
    freshness = Freshness(MANY)
    counted = [seq for seq in numbers if judge(freshness, tag(seq)) is None]
    assert counted == [seq for i, seq in enumerate(numbers) if seq > max(numbers[:i], default=-1)]


def test_each_sender_has_numbers_of_its_own() -> None:
    freshness = Freshness(LIMITS)
    assert judge(freshness, tag(5, "a")) is None
    assert judge(freshness, tag(1, "b")) is None


def test_a_sender_that_is_heard_is_not_forgotten_however_many_others_there_are() -> None:
    freshness = Freshness(MANY)
    for other in range(3 * MOST_SESSIONS):
        assert judge(freshness, tag(other, "mine")) is None
        assert judge(freshness, tag(0, f"other-{other}")) is None
        assert judge(freshness, tag(0, f"other-{other}")) is Refusal.REPLAYED
    assert judge(freshness, tag(0, "mine")) is Refusal.REPLAYED


def test_a_command_counts_until_its_time_to_live_is_over() -> None:
    freshness = Freshness(LIMITS)
    assert judge(freshness, tag(0, ttl_ms=200), age_ms=200) is None
    assert judge(freshness, tag(1, ttl_ms=200), age_ms=200.001) is Refusal.EXPIRED


def test_what_is_too_large_is_refused_whatever_it_says() -> None:
    freshness = Freshness(LIMITS)
    assert freshness.judge(0, 0, 4096, tag(0)) is None
    assert freshness.judge(0, 0, 4097, tag(1)) is Refusal.OVERSIZED


def test_without_a_tag_a_command_counts_only_where_plain_ros_is_allowed() -> None:
    assert judge(Freshness(LIMITS), None) is Refusal.UNTAGGED
    plain = Freshness(CommandLimits(4096, 50, allow_plain=True, plain_ttl_ms=200))
    assert judge(plain, None) is None
    assert judge(plain, None, age_ms=201) is Refusal.EXPIRED


@pytest.mark.parametrize(
    "bad",
    [
        b"",
        b"{",
        b"\xff",
        b'{"session":"a","seq":0}',
        b'{"session":"","seq":0,"ttl_ms":1}',
        b'{"session":"a","seq":-1,"ttl_ms":1}',
        b'{"session":"a","seq":0,"ttl_ms":0}',
        b'{"session":"a","seq":0,"ttl_ms":60001}',
        b'{"session":"a","seq":0,"ttl_ms":NaN}',
        b'{"session":"a","seq":9007199254740993,"ttl_ms":1}',
        b'{"session":"a","seq":0,"ttl_ms":1,"more":1}',
        b'{"session":"a","seq":0,"ttl_ms":1}' + b" " * MOST_BYTES,
        b"[" * 500,
        b'{"session":"a\\n","seq":0,"ttl_ms":1}',
        b'{"session":"\\u001b[2J","seq":0,"ttl_ms":1}',
    ],
)
def test_a_tag_that_is_none_is_refused(bad: bytes) -> None:
    freshness = Freshness(CommandLimits(4096, 50, allow_plain=True))
    assert judge(freshness, bad) is Refusal.BAD_TAG
    assert session_of(bad) == ""


@given(st.binary(max_size=600))
def test_no_bytes_raise_anything_else(junk: bytes) -> None:
    assert judge(Freshness(LIMITS), junk) in (None, Refusal.BAD_TAG)


def test_no_more_than_the_limit_count_however_many_come() -> None:
    freshness = Freshness(CommandLimits(4096, max_hz=50, burst=10))
    refusals = [judge(freshness, tag(seq), now_ms=seq * 0.1) for seq in range(100_000)]  # 10 kHz for 10 s
    assert refusals.count(None) == 10 + 50 * 10 - 1
    assert set(refusals) == {None, Refusal.TOO_MANY}


def test_what_does_not_count_takes_nobody_elses_place() -> None:
    freshness = Freshness(CommandLimits(4096, max_hz=50, burst=10))
    assert judge(freshness, tag(5, "replayed")) is None
    for _ in range(1000):
        assert judge(freshness, tag(5, "replayed")) is Refusal.REPLAYED
    assert judge(freshness, tag(0, "mine")) is None


def test_a_command_that_cannot_be_decoded_is_counted_as_malformed() -> None:
    freshness = Freshness(LIMITS)
    assert judge(freshness, tag(0)) is None
    freshness.malformed()
    assert (freshness.accepted, freshness.counts) == (0, {Refusal.MALFORMED: 1})


def test_what_cannot_be_decoded_takes_no_commands_place() -> None:
    freshness = Freshness(CommandLimits(4096, max_hz=50, burst=2))
    for seq in range(1000):
        assert judge(freshness, tag(seq, "talks rubbish")) is None
        freshness.malformed()
    assert [judge(freshness, tag(seq, "mine")) for seq in range(3)] == [None, None, Refusal.TOO_MANY]


@given(
    st.floats(1, 1000),
    st.integers(1, 20),
    st.lists(st.sampled_from((0, MS, 50 * MS, 1000 * MS)), min_size=1, max_size=100),
)
def test_a_rate_limit_holds_in_every_stretch_of_time(max_hz: float, burst: int, gaps_ns: List[int]) -> None:
    limit, now_ns, allowed_ns = RateLimit(max_hz, burst), 0, []
    for gap_ns in gaps_ns:
        now_ns += gap_ns
        if limit.allows(now_ns):
            allowed_ns.append(now_ns)
    for first, start_ns in enumerate(allowed_ns):
        for count, end_ns in enumerate(allowed_ns[first:], start=1):
            assert count <= burst + (end_ns - start_ns) * max_hz / 1e9 + 1e-6


def test_after_a_long_pause_no_more_come_at_once_than_the_burst() -> None:
    limit = RateLimit(50, 3)
    for now_ns in (0, 10**12, 10**15):
        assert [limit.allows(now_ns) for _ in range(5)] == [True, True, True, False, False]


def test_a_tagger_numbers_what_it_sends() -> None:
    tagger = Tagger("me")
    sample = read_tag(SampleTag, tagger.sample("boot", 7))
    command = read_tag(CommandTag, tagger.command(200))
    assert sample == SampleTag("boot", 7, "me", 0)
    assert command == CommandTag("me", 1, 200)
    assert session_of(tagger.command(200)) == "me"


def test_two_processes_have_different_sessions() -> None:
    assert session_of(Tagger().command(1)) != session_of(Tagger().command(1))


def test_a_tag_of_the_robot_is_no_tag_of_a_command() -> None:
    with pytest.raises(RefusedError, match="tag"):
        read_tag(CommandTag, Tagger().sample("boot", 7))


def test_the_limits_are_those_of_the_configuration() -> None:
    config = BusConfig(max_command_bytes=1000, max_command_hz=20.0, allow_plain_ros=True, cmd_vel_timeout_s=0.3)
    assert limits_of(config) == CommandLimits(1000, 20.0, allow_plain=True, plain_ttl_ms=300)
    assert not limits_of(BusConfig()).allow_plain
