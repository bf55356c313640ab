# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What processes take as time goes by: memory, handles and threads, by /proc; and whether one of them grows."""

from __future__ import annotations

import os
import statistics
from contextlib import suppress
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Sequence, Tuple

MB = 1e6
_PARTS = 5
"""What is compared is the first fifth of the time, and the last."""


class Sample(NamedTuple):
    """Of a process at a time [s]."""

    at_s: float
    rss_mb: float
    handles: int
    threads: int


class Growth(NamedTuple):
    """From the first fifth of the time that is judged to the last, medians of both: what a moment has more or less than
    others is no growth. judged_s: 0: it lived too short."""

    name: str
    judged_s: float
    first: Sample
    last: Sample

    @property
    def rss_mb(self) -> float:
        return self.last.rss_mb - self.first.rss_mb

    @property
    def handles(self) -> int:
        return self.last.handles - self.first.handles

    @property
    def threads(self) -> int:
        return self.last.threads - self.first.threads


def sample(pid: int, at_s: float) -> Sample | None:
    """None where it is no more."""
    folder = Path(f"/proc/{pid}")
    with suppress(OSError):
        pages = int((folder / "statm").read_text(encoding="ascii").split()[1])
        rss_mb = pages * os.sysconf("SC_PAGE_SIZE") / MB
        return Sample(at_s, rss_mb, _count(folder / "fd"), _count(folder / "task"))
    return None


def _count(folder: Path) -> int:
    return sum(1 for _ in folder.iterdir())


class Traces:
    """warm_s: growth before that is none; nor is that of a process in its first fifth of it."""

    def __init__(self, warm_s: float, read: Callable[[int, float], Sample | None] = sample) -> None:
        self._warm_s, self._read = warm_s, read
        self._samples: Dict[Tuple[str, int], List[Sample]] = {}

    def look(self, at_s: float, pids: Dict[str, int]) -> None:
        """At processes by name."""
        for name, pid in pids.items():
            found = self._read(pid, at_s)
            if found is not None:
                self._samples.setdefault((name, pid), []).append(found)

    @property
    def series(self) -> Dict[str, List[Sample]]:
        """All of it, by name and id."""
        return {f"{name} {pid}": samples for (name, pid), samples in self._samples.items()}

    def growths(self) -> List[Growth]:
        """One for each name: of those that had it, the one that lived longest after it was warm."""
        found: Dict[str, Growth] = {}
        for (name, _), samples in self._samples.items():
            growth = self._growth(name, samples)
            if name not in found or growth.judged_s >= found[name].judged_s:
                found[name] = growth
        return list(found.values())

    def _growth(self, name: str, samples: Sequence[Sample]) -> Growth:
        own_s = self._warm_s / _PARTS
        begin_s = max(self._warm_s, samples[0].at_s + own_s)
        warm = [each for each in samples if each.at_s >= begin_s]
        if len(warm) < 2 * _PARTS or warm[-1].at_s - begin_s < own_s:
            return Growth(name, 0.0, samples[-1], samples[-1])
        share = len(warm) // _PARTS
        return Growth(name, warm[-1].at_s - warm[0].at_s, _summed(warm[:share]), _summed(warm[-share:]))


def _summed(samples: Sequence[Sample]) -> Sample:
    at_s, rss_mb, handles, threads = (statistics.median(values) for values in zip(*samples))
    return Sample(at_s, rss_mb, round(handles), round(threads))
