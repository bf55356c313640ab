# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pairs are the nearest there are, come as soon as they can be known, and every message is accounted for."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.perception.sync import Pair, Synchronizer
from edgefusion.types import Frame, Scan

MS = 1_000_000
SECOND = 1000 * MS
IMAGE = np.zeros((1, 1, 3), np.uint8)
RANGES = np.ones(1, np.float32)


def scan(ms: float) -> Scan:
    return Scan(round(ms * MS), RANGES, 0.0, 0.1)


def frame(ms: float) -> Frame:
    return Frame(round(ms * MS), IMAGE)


def play(sync: Synchronizer, arrivals: list[tuple[float, Scan | Frame]]) -> list[tuple[float, Pair]]:
    """Feeds messages in the order of arrival [ms]; returns the pairs with the time at which each came out."""
    out = []
    for now, message in sorted(arrivals, key=lambda arrival: arrival[0]):
        pairs = sync.add_scan(message) if isinstance(message, Scan) else sync.add_frame(message)
        out += [(now, pair) for pair in pairs]
    return out


def stream(make, period_ms: float, delay_ms: float, n: int, start_ms: float = 0.0):
    return [
        (start_ms + i * period_ms + delay_ms, make(start_ms + i * period_ms))
        for i in range(n)
    ]  # fmt: skip


def synchronizer(tolerance_ms: float = 100, horizon_ms: float = 1000) -> Synchronizer:
    return Synchronizer(round(tolerance_ms * MS), round(horizon_ms * MS))


def test_equal_stamps_pair_at_once() -> None:
    sync = synchronizer()
    for ms in (0, 100, 200):
        assert sync.add_scan(scan(ms)) == []
        (pair,) = sync.add_frame(frame(ms))
        assert (pair.scan.stamp_ns, pair.dt_ns) == (ms * MS, 0)


def test_at_38400_baud_the_frame_that_is_already_old_is_taken_at_once() -> None:
    """5 Hz scans, 0.2 s old on arrival; 30 Hz frames, 40 ms old."""
    arrivals = stream(scan, 192, 200, 40, 11) + stream(frame, 1000 / 30, 40, 240)
    pairs = play(synchronizer(), arrivals)
    assert len(pairs) == 40
    for now, pair in pairs[1:]:  # the first scan cannot know when the next will come
        assert abs(pair.dt_ns) <= 1000 / 30 / 2 * MS + 1
        assert now == pair.scan.stamp_ns / MS + 200


@pytest.mark.parametrize("frame_hz", [10, 15, 24, 30])
def test_slower_frames_each_get_the_nearest_of_many_scans_when_they_arrive(frame_hz: int) -> None:
    """37.5 Hz scans, 20 ms old on arrival; frames 60 ms old."""
    arrivals = stream(scan, 1000 / 37.5, 20, 200) + stream(frame, 1000 / frame_hz, 60, 5 * frame_hz, 7)
    pairs = play(synchronizer(), arrivals)
    assert len(pairs) == 5 * frame_hz
    for now, pair in pairs[2:]:  # the pace of the frames shows with the second
        assert abs(pair.dt_ns) <= 1000 / 37.5 / 2 * MS + 1
        assert now == pytest.approx(pair.frame.stamp_ns / MS + 60)


@given(st.integers(0, 2**32), st.sampled_from([10, 15, 30]))
def test_jitter_and_lost_messages_cost_few_waits_and_hardly_a_nearer_partner(seed: int, frame_hz: int) -> None:
    """37.5 Hz scans and frames 60 ms late, 2 ms of jitter, every twentieth lost."""
    rng = np.random.default_rng(seed)

    def shaken(messages):
        moved = [(now, ms + rng.uniform(-2, 2)) for now, ms in messages if rng.random() > 0.05]
        return [(now + 2, ms) for now, ms in moved]

    scans = shaken(stream(float, 1000 / 37.5, 20, 150))
    frames = shaken(stream(float, 1000 / frame_hz, 60, 4 * frame_hz, 7))
    arrivals = [(now, scan(ms)) for now, ms in scans] + [(now, frame(ms)) for now, ms in frames]
    pairs = play(synchronizer(), arrivals)
    assert len(pairs) >= 0.9 * len(frames)
    arrived = {round(ms * MS): now for now, ms in frames}
    at_once = sum(now == arrived[pair.frame.stamp_ns] for now, pair in pairs)
    nearest = sum(
        abs(pair.dt_ns) <= min(abs(round(ms * MS) - pair.frame.stamp_ns) for _, ms in scans) for _, pair in pairs
    )
    assert at_once >= 0.8 * len(pairs)
    assert nearest >= 0.9 * len(pairs)


def test_a_scan_waits_for_a_nearer_frame_that_is_still_on_its_way() -> None:
    sync = synchronizer()
    play(sync, stream(frame, 33, 0, 4) + stream(scan, 50, 0, 2, 20))  # newest at 99 and 70
    assert sync.add_scan(scan(120)) == []  # the next frame, at 132, will be nearer
    (pair,) = sync.add_frame(frame(132))
    assert pair.dt_ns == 12 * MS


def test_nothing_beyond_the_tolerance_is_paired_and_nothing_within_is_refused() -> None:
    """FAULTS S1: skews of 0 to 500 ms."""
    for skew_ms in range(0, 501, 20):
        arrivals = stream(scan, 1000, 0, 6) + stream(frame, 1000, 0.5, 6, skew_ms)
        pairs = play(synchronizer(tolerance_ms=100), arrivals)
        if skew_ms > 100:
            assert pairs == []
        else:
            assert len(pairs) >= 5  # the last may still wait
            assert {pair.dt_ns for _, pair in pairs} == {skew_ms * MS}


def test_a_silent_stream_costs_no_memory_and_is_not_waited_for() -> None:
    sync = synchronizer()
    pairs = play(sync, [(0.0, frame(0)), *stream(scan, 27, 0.1, 4000, 20)])
    assert [pair.frame.stamp_ns for _, pair in pairs] == [0]  # within half the horizon, not for ever
    assert pairs[0][0] < 600
    waiting = 4001 - sum(sync.counts.values()) - 0
    assert waiting <= 1000 / 27 + 2
    assert sync.counts["scan without partner"] > 3900
    resumed = play(sync, stream(frame, 100, 1, 5, 4000 * 27 - 300))
    assert resumed


def test_a_clock_that_jumps_back_starts_both_streams_anew() -> None:
    sync = synchronizer()
    hour = 3_600_000
    before = play(sync, stream(scan, 100, 0, 10, hour) + stream(frame, 100, 1, 10, hour))
    after = play(sync, stream(scan, 100, 0, 10) + stream(frame, 100, 1, 10))
    assert len(before) == 10
    assert len(after) == 10
    assert [pair.scan.stamp_ns for _, pair in after] == [i * 100 * MS for i in range(10)]


def test_a_clock_that_jumps_ahead_drops_what_waited_and_goes_on() -> None:
    sync = synchronizer()
    hour = 3_600_000
    play(sync, stream(scan, 100, 0, 10) + stream(frame, 100, 1, 10, 40))
    after = play(sync, stream(scan, 100, 0, 10, hour) + stream(frame, 100, 1, 10, hour))
    dts = [pair.dt_ns for _, pair in after if pair.scan.stamp_ns >= hour * MS]
    assert dts == [0] * 10


def test_messages_in_flight_while_a_recording_starts_over_cost_no_more_than_themselves() -> None:
    """The scans start over 0.3 s before the frames do, so that old and new stamps arrive in turn."""
    sync = synchronizer()
    hour = 3_600_000
    old = stream(scan, 100, 0, 20, hour) + stream(frame, 100, 300, 20, hour)
    new = [(hour + 2000 + now, message) for now, message in stream(scan, 100, 0, 20) + stream(frame, 100, 300, 20)]
    pairs = [pair for _, pair in play(sync, old + new)]
    assert len([pair for pair in pairs if pair.scan.stamp_ns >= hour * MS]) >= 16
    assert len([pair for pair in pairs if pair.scan.stamp_ns < hour * MS]) >= 16
    assert all(pair.dt_ns == 0 for pair in pairs)


def test_one_stamp_that_is_hours_ahead_does_not_stop_the_pairing() -> None:
    sync = synchronizer()
    play(sync, stream(scan, 100, 0, 10) + stream(frame, 100, 1, 10))
    sync.add_scan(scan(3_600_000))
    after = play(sync, stream(scan, 100, 0, 10, 1000) + stream(frame, 100, 1, 10, 1000))
    assert len(after) == 10


def test_the_last_pair_of_a_recording_is_flushed() -> None:
    sync = synchronizer()
    assert sync.flush() == []
    sync.add_scan(scan(0))
    assert sync.add_frame(frame(30)) == []  # the next scan may be nearer
    (pair,) = sync.flush()
    assert pair.dt_ns == 30 * MS
    assert sync.flush() == []
    assert sync.counts == {"scan paired": 1, "frame paired": 1}


def test_what_is_flushed_is_within_the_tolerance() -> None:
    sync = synchronizer(tolerance_ms=20)
    play(sync, [(0, scan(0)), (1, frame(30))])
    assert sync.flush() == []


def test_a_stamp_that_does_not_rise_is_dropped_and_counted() -> None:
    sync = synchronizer()
    for ms in (0, 50, 50, 40):
        sync.add_scan(scan(ms))
    assert sync.counts == {"scan duplicate stamp": 1, "scan out of order": 1}


deltas = st.integers(1, 300)
streams = st.tuples(
    st.lists(deltas, max_size=40), st.lists(deltas, max_size=40), st.integers(0, 400), st.integers(0, 400)
)


def arrivals_of(streams) -> list[tuple[float, Scan | Frame]]:
    scan_steps, frame_steps, scan_delay, frame_delay = streams
    return [(ms + scan_delay, scan(ms)) for ms in np.cumsum(scan_steps, dtype=int).tolist()] + [
        (ms + frame_delay + 0.5, frame(ms)) for ms in np.cumsum(frame_steps, dtype=int).tolist()
    ]


@given(streams)
def test_every_message_is_used_at_most_once_and_the_output_rises(streams) -> None:
    pairs = [pair for _, pair in play(synchronizer(tolerance_ms=80), arrivals_of(streams))]
    for part in ("scan", "frame"):
        stamps = [getattr(pair, part).stamp_ns for pair in pairs]
        assert stamps == sorted(set(stamps))
    assert all(abs(pair.dt_ns) <= 80 * MS for pair in pairs)


@given(streams)
def test_every_message_is_paired_or_dropped_for_a_reason_or_still_waits(streams) -> None:
    sync = synchronizer(tolerance_ms=80)
    arrivals = arrivals_of(streams)
    pairs = play(sync, arrivals)
    counted: Counter[str] = Counter()
    for reason, n in sync.counts.items():
        counted[reason.split()[0]] += n
    for part, kind in (("scan", Scan), ("frame", Frame)):
        assert sync.counts.get(f"{part} paired", 0) == len(pairs)
        sent = [message for _, message in arrivals if isinstance(message, kind)]
        newest = max((message.stamp_ns for _, message in arrivals), default=0)
        recent = sum(message.stamp_ns >= newest - SECOND for message in sent)
        assert 0 <= len(sent) - counted[part] <= recent


@given(streams)
def test_a_pair_is_mutually_nearest_among_what_had_arrived(streams) -> None:
    """Of the messages that had arrived by then and that no earlier pair had overtaken, neither had a nearer one."""
    arrivals = sorted(arrivals_of(streams), key=lambda arrival: arrival[0])
    sync = synchronizer(tolerance_ms=80)
    last_scan = last_frame = -1
    for i, (_, message) in enumerate(arrivals):
        for pair in sync.add_scan(message) if isinstance(message, Scan) else sync.add_frame(message):
            there = [m for _, m in arrivals[: i + 1]]
            scans = [m.stamp_ns for m in there if isinstance(m, Scan) and m.stamp_ns > last_scan]
            frames = [m.stamp_ns for m in there if isinstance(m, Frame) and m.stamp_ns > last_frame]
            assert abs(pair.dt_ns) == min(abs(pair.scan.stamp_ns - ns) for ns in frames)
            assert abs(pair.dt_ns) == min(abs(pair.frame.stamp_ns - ns) for ns in scans)
            last_scan, last_frame = pair.scan.stamp_ns, pair.frame.stamp_ns


@given(st.integers(5, 60), st.integers(5, 60), st.integers(0, 250), st.integers(0, 250), st.integers(0, 50))
def test_even_streams_pair_as_if_all_had_been_known_beforehand(scan_ms, frame_ms, scan_delay, frame_delay, offset):
    """At a steady pace, whatever the delays: the pairs are those of an oracle that sees both whole streams."""
    scans = stream(scan, scan_ms, scan_delay, 2000 // scan_ms, offset)
    frames = stream(frame, frame_ms, frame_delay + 0.25, 2000 // frame_ms)
    pairs = [pair for _, pair in play(synchronizer(tolerance_ms=40, horizon_ms=2000), scans + frames)]
    chosen = {(pair.scan.stamp_ns, pair.frame.stamp_ns) for pair in pairs}
    scan_ns = [m.stamp_ns for _, m in scans]
    frame_ns = [m.stamp_ns for _, m in frames]
    mutual = {
        (s, f)
        for s in scan_ns
        for f in frame_ns
        if abs(s - f) <= 40 * MS
        and abs(s - f) < min((abs(s - g) for g in frame_ns if g != f), default=SECOND)
        and abs(s - f) < min((abs(t - f) for t in scan_ns if t != s), default=SECOND)
    }
    settled = min(scan_ns[-1], frame_ns[-1]) - 300 * MS
    assert {pair for pair in mutual if max(pair) < settled} <= chosen
