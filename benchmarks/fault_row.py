# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One line of the table of faults: how long it took, each time it was injected, until what was to happen happened."""

from __future__ import annotations

import statistics
from dataclasses import dataclass, field
from typing import List

ALLOWED = 3.0
"""Machines are loaded: a figure fails beyond so many times its limit."""


@dataclass(frozen=True)
class FaultRow:
    """figure: as L1. what: the fault and what is timed. aim: in words. limit_s: the same in seconds; inf where it is no
    time. seconds: each; empty where it is no time: the remark says what came of it then. failed: that it is bad."""

    figure: str
    what: str
    aim: str
    limit_s: float
    seconds: List[float] = field(default_factory=list)
    remark: str = ""
    failed: bool = False

    @property
    def median_s(self) -> float:
        return statistics.median(self.seconds)

    @property
    def worst_s(self) -> float:
        return max(self.seconds)

    @property
    def met(self) -> bool:
        """Whether the worst keeps the aim."""
        return not self.failed and (not self.seconds or self.worst_s <= self.limit_s)

    @property
    def broken(self) -> bool:
        """Whether it is so far off that no load of the machine explains it."""
        return self.failed or (bool(self.seconds) and self.worst_s > ALLOWED * self.limit_s)
