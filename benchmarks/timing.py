# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Fair timing: the candidates take turns, so a busy moment of the machine hits all of them."""

import statistics
import time
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional


@dataclass(frozen=True)
class Row:
    """One line of the table; `ratio` says how many times faster than the peer, `aim` how many were promised."""

    name: str
    product_s: float
    peer: str
    peer_s: float
    ratio: float
    aim: Optional[float]


def interleaved(candidates: Dict[str, Callable[[], object]], rounds: int) -> Dict[str, float]:
    """Median seconds per call of each candidate, called in turn `rounds` times."""
    times: Dict[str, List[float]] = {name: [] for name in candidates}
    for _ in range(rounds):
        for name, call in candidates.items():
            start = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - start)
    return {name: statistics.median(taken) for name, taken in times.items()}
