# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Goals that are none: random, changed and cut off bytes, as often as wanted; how they are refused, and how soon."""

from __future__ import annotations

import math
import time
from typing import Callable, Dict, List, Tuple

import msgspec
import numpy as np
from benchmarks.fault_row import FaultRow

from edgefusion.bus.freshness import CommandLimits, Freshness, Refusal
from edgefusion.bus.tags import CommandTag
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.from_goal_pose import from_goal_pose
from edgefusion.messages.geometry_msgs import PoseStamped
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_goal_pose import to_goal_pose
from edgefusion.types import Pose2D

PAYLOADS = 50_000
"""Each seed's; of twenty a million."""


def hostile(seeds: int, tick: Callable[[], object]) -> List[FaultRow]:
    """tick: called after every seed."""
    seconds: List[float] = []
    counts: Dict[str, int] = {}
    for seed in range(seeds):
        p99_s, found = _one(seed)
        seconds.append(p99_s)
        for outcome, count in found.items():
            counts[outcome] = counts.get(outcome, 0) + count
        tick()
    remark = ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items()))
    failed = any(outcome.startswith("raised") for outcome in counts)
    return [FaultRow("Z6", "goals that are none: judged and decoded, p99", "1 ms", 0.001, seconds, remark, failed)]


def _one(seed: int) -> Tuple[float, Dict[str, int]]:
    rng = np.random.default_rng(seed)
    freshness = Freshness(CommandLimits(4096, 1e6, burst=PAYLOADS))
    good = encode(from_goal_pose(0, Pose2D(1.0, 2.0, 0.3), Stamper(1_700_000_000_000_000_000)))
    seconds: List[float] = []
    counts: Dict[str, int] = {}
    for number in range(PAYLOADS):
        seq = number if number % 10 else max(0, number - 1)
        payload, tag = _payload(rng, good), msgspec.json.encode(CommandTag("hostile", seq, 200))
        start_s = time.perf_counter()
        outcome = _outcome(freshness, number, payload, tag)
        seconds.append(time.perf_counter() - start_s)
        counts[outcome] = counts.get(outcome, 0) + 1
    return float(np.percentile(seconds, 99)), counts


def _payload(rng: np.random.Generator, good: bytes) -> bytes:
    kind = rng.integers(4)
    if kind == 0:
        return bytes(rng.bytes(int(rng.integers(0, 200))))
    if kind == 1:
        return good[: int(rng.integers(0, len(good)))]
    if kind == 2:
        return good + bytes(rng.bytes(int(rng.integers(1, 6000))))
    changed = bytearray(good)
    for _ in range(int(rng.integers(1, 4))):
        changed[int(rng.integers(0, len(changed)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _outcome(freshness: Freshness, number: int, payload: bytes, tag: bytes) -> str:
    try:
        refusal = freshness.judge(number * 1000, number * 1000, len(payload), tag)
        if refusal is not None:
            return refusal.value
        goal = to_goal_pose(decode(PoseStamped, payload))
    except RefusedError:
        return Refusal.MALFORMED.value
    except Exception as error:
        return f"raised {type(error).__name__}"
    return "goals" if all(map(math.isfinite, (goal.pose.x_m, goal.pose.y_m, goal.pose.theta))) else "raised nothing"
