# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Step 1 of the paper: a scan and a frame that were captured together, by their stamps.

Both streams come in the order of their own stamps, late by different delays: at 38400 baud a scan arrives 0.2 s after
its middle beam, when the frame that matches it is long there. No clock is read; only arriving stamps drive it.

A pair is proposed when its scan and its frame are each other's nearest among the unused ones, within the tolerance.
The earliest proposed pair is emitted once waiting cannot improve it: the next frame of the stream would be no nearer to
the scan, nor the next scan to the frame. The next message is expected no sooner than the shortest of the last eight
intervals of its stream: at a steady pace every pair is the one that an oracle would choose, and where a message comes
sooner than that, a pair may be the second best. A stream that falls silent is not waited for longer than half the
horizon, and at the end of a recording `flush` gives the pairs that still wait.

Every message ends once: paired, dropped for a reason that `counts` names, or still in the buffer.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, deque
from typing import Generic, NamedTuple, TypeVar, Union

from edgefusion.types import Frame, Scan

Message = TypeVar("Message", bound=Union[Scan, Frame])


class Pair(NamedTuple):
    """A scan and a frame that were captured together."""

    scan: Scan
    frame: Frame

    @property
    def dt_ns(self) -> int:
        """The frame's stamp minus the scan's."""
        return self.frame.stamp_ns - self.scan.stamp_ns


class Synchronizer:
    """Pairs scans and frames; each is used at most once, and the pairs' stamps rise.

    tolerance_ns: the largest difference of a pair's stamps. horizon_ns: how long a message waits for its partner, and
    how far a stamp may step back before it is taken for a jump of the clock, which starts both streams anew.
    """

    def __init__(self, tolerance_ns: int, horizon_ns: int) -> None:
        self._tolerance_ns, self._horizon_ns = tolerance_ns, horizon_ns
        self._counts: Counter[str] = Counter()
        self._scans: _Stream[Scan] = _Stream("scan", self._counts)
        self._frames: _Stream[Frame] = _Stream("frame", self._counts)

    @property
    def counts(self) -> dict[str, int]:
        """How many messages ended how: "scan paired", "frame superseded", ..."""
        return dict(self._counts)

    def add_scan(self, scan: Scan) -> list[Pair]:
        """Takes a scan; returns the pairs that are complete now, in order."""
        return self._emit() if self._admit(self._scans, scan) else []

    def add_frame(self, frame: Frame) -> list[Pair]:
        """Takes a frame; returns the pairs that are complete now, in order."""
        return self._emit() if self._admit(self._frames, frame) else []

    def flush(self) -> list[Pair]:
        """The pairs that still wait for something nearer, for the end of a recording."""
        return self._emit(waiting=True)

    def _admit(self, stream: _Stream[Message], message: Message) -> bool:
        if stream.newest_ns is not None and message.stamp_ns < stream.newest_ns - self._horizon_ns:
            self._scans.start_anew()
            self._frames.start_anew()
        return stream.append(message)

    def _emit(self, waiting: bool = False) -> list[Pair]:
        """Takes out the pairs that are final, or, where nothing more will come, those that wait as well."""
        pairs = []
        while True:
            pair = self._earliest_mutual()
            if pair is None or not (waiting or self._is_final(pair)):
                break
            self._scans.take(pair.scan.stamp_ns)
            self._frames.take(pair.frame.stamp_ns)
            pairs.append(pair)
        oldest_ns = self._newest_ns() - self._horizon_ns
        self._scans.drop_before(oldest_ns)
        self._frames.drop_before(oldest_ns)
        return pairs

    def _newest_ns(self) -> int:
        return max((ns for ns in (self._scans.newest_ns, self._frames.newest_ns) if ns is not None), default=0)

    def _earliest_mutual(self) -> Pair | None:
        """The first scan and frame that are each other's nearest, within the tolerance."""
        for scan in self._scans.waiting:
            frame = self._frames.nearest(scan.stamp_ns)
            if frame is None or abs(frame.stamp_ns - scan.stamp_ns) > self._tolerance_ns:
                continue
            if self._scans.nearest(frame.stamp_ns) is scan:
                return Pair(scan, frame)
        return None

    def _is_final(self, pair: Pair) -> bool:
        """Whether nothing that is yet to come could be nearer to the scan or to the frame."""
        scan_ns, frame_ns = pair.scan.stamp_ns, pair.frame.stamp_ns
        apart_ns = abs(pair.dt_ns)
        if self._frames.next_ns() >= scan_ns + apart_ns and self._scans.next_ns() >= frame_ns + apart_ns:
            return True
        return self._newest_ns() - max(scan_ns, frame_ns) >= self._horizon_ns // 2


class _Stream(Generic[Message]):
    """The messages of one stream that wait for a partner, oldest first, and the pace of the stream."""

    def __init__(self, name: str, counts: Counter[str]) -> None:
        self._name, self._counts = name, counts
        self.waiting: list[Message] = []
        self._stamps_ns: list[int] = []  # of those that wait
        self.newest_ns: int | None = None
        self._intervals_ns: deque[int] = deque(maxlen=8)

    def append(self, message: Message) -> bool:
        """Takes a message, unless its stamp does not rise; says whether it did."""
        if self.newest_ns is not None and message.stamp_ns <= self.newest_ns:
            self._count("out of order" if message.stamp_ns < self.newest_ns else "duplicate stamp", 1)
            return False
        if self.newest_ns is not None:
            self._intervals_ns.append(message.stamp_ns - self.newest_ns)
        self.newest_ns = message.stamp_ns
        self.waiting.append(message)
        self._stamps_ns.append(message.stamp_ns)
        return True

    def next_ns(self) -> int:
        """The earliest stamp that the next message should have: the shortest of the recent intervals ahead."""
        assert self.newest_ns is not None
        return self.newest_ns + min(self._intervals_ns, default=1)

    def nearest(self, stamp_ns: int) -> Message | None:
        """The waiting message nearest to a stamp, the earlier of two that are equally near."""
        after = bisect_left(self._stamps_ns, stamp_ns)
        around = self.waiting[max(after - 1, 0) : after + 1]
        return min(around, key=lambda message: abs(message.stamp_ns - stamp_ns), default=None)

    def take(self, stamp_ns: int) -> None:
        """Removes the message of this stamp as paired, and those before it, which the pair has overtaken."""
        self._drop_older(stamp_ns, "superseded")
        self._drop_older(stamp_ns + 1, "paired")

    def drop_before(self, oldest_ns: int) -> None:
        """Drops what has waited for longer than the horizon."""
        self._drop_older(oldest_ns, "without partner")

    def start_anew(self) -> None:
        """Forgets everything: the clock has jumped."""
        self._drop(len(self.waiting), "time jump")
        self._intervals_ns.clear()
        self.newest_ns = None

    def _drop_older(self, stamp_ns: int, reason: str) -> None:
        self._drop(bisect_left(self._stamps_ns, stamp_ns), reason)

    def _drop(self, number: int, reason: str) -> None:
        del self.waiting[:number], self._stamps_ns[:number]
        self._count(reason, number)

    def _count(self, reason: str, number: int) -> None:
        if number:
            self._counts[f"{self._name} {reason}"] += number
