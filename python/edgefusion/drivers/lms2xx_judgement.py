# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a laser's scans may be driven by: three ways in which telegrams with a right checksum say nothing.

A line so noisy that the checksum may hold by chance, a scanner that repeats itself, a window that sees nothing.
"""

from __future__ import annotations

from collections import deque
from typing import Deque

import numpy as np
import numpy.typing as npt

Ranges = npt.NDArray[np.float32]

TELEGRAMS, INTACT_SHARE = 20, 0.8
"""Of the last so many, such a share must have been intact. This checksum lets one of 9000 telegrams pass of which two
bytes are wrong: on a line on which that is not rare, any scan may be false."""

REPEATS, REPEATED_NS, MET_BEAMS = 5, 1_000_000_000, 30
"""So many equal scans in a row while the wheels turn, or equal ones for so long, with so many beams that met something:
noise alone makes two scans differ, but in an empty hall."""

COVERED_SCANS, COVERED_SHARE, COVERED_M = 2, 0.9, 0.1
"""So many scans in a row in which such a share of the beams knows nothing, or is nearer than that."""


class LineQuality:
    """Which of the last telegrams were intact. discarded_bytes: of the stream so far."""

    def __init__(self, discarded_bytes: int) -> None:
        self._intact: Deque[bool] = deque(maxlen=TELEGRAMS)
        self._discarded_bytes = discarded_bytes

    def telegram(self, size: int, discarded_bytes: int) -> None:
        """One came that is intact, of so many bytes; discarded_bytes: of the stream, in all, before it."""
        broken = round((discarded_bytes - self._discarded_bytes) / size)
        self._discarded_bytes = discarded_bytes
        self._intact.extend([False] * min(broken, TELEGRAMS))
        self._intact.append(True)

    @property
    def fault(self) -> str:
        """Empty while the line is good enough."""
        intact, known = sum(self._intact), len(self._intact)
        good = intact >= INTACT_SHARE * known
        return "" if good else f"the line is noisy: {intact} of the last {known} telegrams were intact"


class Repetition:
    """Whether the same scan comes again and again."""

    def __init__(self) -> None:
        self._values = b""
        self._since_ns = 0
        self._repeats = 0

    def fault(self, values: bytes, ranges_m: Ranges, now_ns: int, moving: bool) -> str:
        """Of a scan that came just now, its values as they are in the telegram. Empty where it may be believed."""
        if values != self._values:
            self._values, self._since_ns, self._repeats = values, now_ns, 0
        self._repeats += 1
        if np.isfinite(ranges_m).sum() < MET_BEAMS:
            return ""
        too_often = moving and self._repeats >= REPEATS
        too_long = now_ns - self._since_ns >= REPEATED_NS
        return f"it repeats itself: {self._repeats} equal scans" if too_often or too_long else ""


class Cover:
    """Whether it sees anything."""

    def __init__(self) -> None:
        self._blind = 0

    def fault(self, ranges_m: Ranges) -> str:
        """Of one scan after the other. Empty where it sees."""
        blind = np.isnan(ranges_m) | (ranges_m < COVERED_M)
        self._blind = self._blind + 1 if blind.mean() >= COVERED_SHARE else 0
        if self._blind < COVERED_SCANS:
            return ""
        return f"covered or dazzled: {blind.sum()} of {len(ranges_m)} beams see nothing"


class Judgement:
    """All three, of one scanner from its start on. discarded_bytes: of its stream, until then."""

    def __init__(self, discarded_bytes: int = 0) -> None:
        self.line = LineQuality(discarded_bytes)
        self._repetition, self._cover = Repetition(), Cover()

    def fault(self, values: bytes, ranges_m: Ranges, now_ns: int, moving: bool) -> str:
        """Why this scan is not to be driven by; empty where it may be. moving: whether the robot's wheels turn."""
        faults = (
            self.line.fault,
            self._repetition.fault(values, ranges_m, now_ns, moving),
            self._cover.fault(ranges_m),
        )
        return "; ".join(fault for fault in faults if fault)
