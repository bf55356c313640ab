# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Fair timing: the candidates take turns, so a busy moment of the machine hits all of them."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import Callable, Mapping

MIN_SAMPLE_S = 1e-3
"""A sample repeats a quick call until it takes this long, far above the resolution of the clock."""


@dataclass(frozen=True)
class Row:
    """One line of the table; `ratio`: how many times faster than the peer, `aim`: how many were promised."""

    name: str
    product_s: float
    peer: str
    peer_s: float
    ratio: float
    aim: float | None


def interleaved(candidates: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median seconds per call of each candidate, sampled in turn `rounds` times after a warm-up."""
    calls = {name: _calls_per_sample(call) for name, call in candidates.items()}
    samples: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(rounds):
        for name, call in candidates.items():
            samples[name].append(_sample(call, calls[name]) / calls[name])
    return {name: statistics.median(taken) for name, taken in samples.items()}


def _calls_per_sample(call: Callable[[], object]) -> int:
    call()  # the first call pays for memory and caches
    calls = 1
    while _sample(call, calls) < MIN_SAMPLE_S:
        calls *= 2
    return calls


def _sample(call: Callable[[], object], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        call()
    return time.perf_counter() - start
