# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Z6: goals that are none, from somebody who may command: random bytes, and real goals changed, cut and lengthened."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Callable, List

import numpy as np
from benchmarks.fault_row import FaultRow

from edgefusion.messages.cdr import WireError, decode, encode
from edgefusion.messages.from_goal_pose import from_goal_pose
from edgefusion.messages.geometry_msgs import PoseStamped
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_goal_pose import to_goal_pose
from edgefusion.types import Pose2D

PAYLOADS = 50_000
"""Of a run: twenty of them are the million that the figure asks for."""
LIMIT_S = 1e-3
MOST_BYTES = 4096
"""What is longer is refused before it is read."""
_LITTLE = bytes([0, 1, 0, 0])
_HUGE = (0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)


@dataclass
class HostileGoals:
    """understood: payloads that are goals all the same. refused: with WireError. others: what else was raised.

    seconds: each payload's, until it was understood or refused.
    """

    understood: int = 0
    refused: int = 0
    others: List[str] = field(default_factory=list)
    seconds: List[float] = field(default_factory=list)

    @property
    def p99_s(self) -> float:
        return float(np.quantile(self.seconds, 0.99))


def hostile_goals(rng: np.random.Generator, payloads: int) -> HostileGoals:
    """As many payloads, of every kind as many; the same generator gives the same."""
    run = HostileGoals()
    for number in range(payloads):
        payload = KINDS[number % len(KINDS)](rng)
        begun_s = time.perf_counter()
        try:
            to_goal_pose(decode(PoseStamped, payload))
            run.understood += 1
        except WireError:
            run.refused += 1
        except Exception as error:  # what must not happen is told, not hidden
            run.others.append(f"{payload.hex()}: {error!r}")
        run.seconds.append(time.perf_counter() - begun_s)
    return run


def rows(seeds: int, tick: Callable[[], object]) -> List[FaultRow]:
    """The figure, of so many runs. tick: called after each."""
    runs = []
    for seed in range(seeds):
        runs.append(hostile_goals(np.random.default_rng(seed), PAYLOADS))
        tick()
    others = sum(len(run.others) for run in runs)
    understood = sum(run.understood for run in runs)
    remark = f"{seeds * PAYLOADS} payloads, {others} other exceptions, {understood} were goals all the same"
    aim = "WireError alone, p99 <= 1 ms"
    what = "malformed goals, p99 until understood or refused"
    return [FaultRow("Z6", what, aim, LIMIT_S, [run.p99_s for run in runs], remark, failed=others > 0)]


def _goal(rng: np.random.Generator) -> bytes:
    pose = Pose2D(rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-3, 3))
    return encode(from_goal_pose(int(rng.integers(2**60)), pose, Stamper()))


def _noise(rng: np.random.Generator) -> bytes:
    return rng.bytes(int(rng.integers(MOST_BYTES)))


def _noise_with_a_header(rng: np.random.Generator) -> bytes:
    return _LITTLE + _noise(rng)[:256]


def _mutated(rng: np.random.Generator) -> bytes:
    data = bytearray(_goal(rng))
    for at in rng.integers(len(data), size=int(rng.integers(1, 9))).tolist():
        data[at] = int(rng.integers(256))
    return bytes(data)


def _lying(rng: np.random.Generator) -> bytes:
    """Wherever a length may be, there is a huge one."""
    data, at = _goal(rng), 4 * int(rng.integers(1, 20))
    return data[:at] + int(rng.choice(_HUGE)).to_bytes(4, "little") + data[at + 4 :]


def _cut(rng: np.random.Generator) -> bytes:
    data = _goal(rng)
    return data[: int(rng.integers(len(data)))]


def _lengthened(rng: np.random.Generator) -> bytes:
    return _goal(rng) + rng.bytes(int(rng.integers(1, 64)))


KINDS = (_noise, _noise_with_a_header, _mutated, _lying, _cut, _lengthened)
