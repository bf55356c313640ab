# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The time of a soak: in every period one fault, at a random moment while the robot drives, which is then mended."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import islice
from typing import Callable, Iterator, List, Sequence

import numpy as np
from benchmarks.soak_faults import SoakFault
from benchmarks.soak_rig import SoakRig

DRIVES_S = 30.0
"""So long it is waited for a robot that drives; it may stand before an object, or turn."""

AGAIN_S = 60.0
"""After a fault was mended it drives again within this."""

_LEAST_S, _MOST_S, _PATIENCE_S = 3.0, 8.0, 5.0


@dataclass(frozen=True)
class Happened:
    """A fault at a time [s]. took_s: until what was wanted happened, or the longest time without a command; None where
    nothing was wanted, or the robot did not drive. again_s: from mending until it drove again. touched: contacts;
    unhelped: of those while it heard nothing."""

    fault: SoakFault
    at_s: float
    took_s: float | None
    again_s: float
    touched: int
    unhelped: int = 0

    @property
    def missed(self) -> bool:
        return self.took_s is not None and self.took_s > self.fault.limit_s


def drawn(faults: Sequence[SoakFault], rng: np.random.Generator) -> Iterator[SoakFault]:
    """For ever: all of them in a random order, and again in another."""
    while faults:
        for number in rng.permutation(len(faults)):
            yield faults[int(number)]


def in_turn(faults: Sequence[SoakFault], rng: np.random.Generator, is_early: Callable[[], bool]) -> Iterator[SoakFault]:
    """Of those that may be at any time; while it is early, every second one is one that must be."""
    early = drawn([fault for fault in faults if fault.early], rng)
    for fault in drawn([fault for fault in faults if not fault.early], rng):
        if is_early():
            yield from islice(early, 1)
        yield fault


class Soak:
    """say: is told of every fault, when it is over."""

    def __init__(self, rig: SoakRig, period_s: float, total_s: float, say: Callable[[Happened], object]) -> None:
        self._rig, self._period_s, self._total_s, self._say = rig, period_s, total_s, say
        self._hold_s = min(_MOST_S, period_s / 2)
        self._begun_s, self._number = rig.now_s, 0
        self.happened: List[Happened] = []

    def run(self, faults: Sequence[SoakFault], tick: Callable[[float], object] = lambda _: None) -> None:
        """tick: told of the seconds that have passed since the last time."""
        last_s = 0.0
        for fault in in_turn(faults, self._rig.rng, lambda: self._next_ends_s <= self._total_s / 3):
            if self._next_ends_s > self._total_s:
                break
            self._wait(self._number * self._period_s - self._passed_s)
            self._one(fault)
            self._number = max(self._number + 1, math.ceil(self._passed_s / self._period_s))
            tick(self._passed_s - last_s)
            last_s = self._passed_s
        self._wait(self._total_s - self._passed_s)
        tick(self._passed_s - last_s)

    @property
    def _next_ends_s(self) -> float:
        """The period that is next."""
        return (self._number + 1) * self._period_s

    @property
    def _passed_s(self) -> float:
        return self._rig.now_s - self._begun_s

    def _wait(self, seconds: float) -> None:
        self._rig.until(lambda: False, max(0.0, seconds))

    def _one(self, fault: SoakFault) -> None:
        rig, rng = self._rig, self._rig.rng
        self._wait(float(rng.uniform(0.0, self._period_s / 4)))
        drove, contacts = rig.until(lambda: rig.drives, DRIVES_S), rig.contacts
        hold_s = float(rng.uniform(min(_LEAST_S, self._hold_s), self._hold_s))
        injected_s, at_s = rig.now_s, self._passed_s
        rig.note(fault.name)
        fault.inject(rig)
        took_s = self._took_s(fault, injected_s) if drove else None
        unhelped = rig.contacts - contacts if fault.deaf else 0
        if not fault.mends_itself or fault.wanted == "heard":
            self._wait(injected_s + hold_s - rig.now_s)
        if drove and fault.wanted == "heard":
            took_s = rig.told.longest_silence_s(injected_s, rig.now_s)
        fault.mend(rig)
        rig.note(f"{fault.name} is over")
        mended_s = rig.now_s
        again_s = rig.now_s - mended_s if rig.until(lambda: rig.drives, AGAIN_S) else math.inf
        touched = rig.contacts - contacts - unhelped
        self.happened.append(Happened(fault, at_s, took_s, again_s, touched, unhelped))
        self._say(self.happened[-1])

    def _took_s(self, fault: SoakFault, injected_s: float) -> float | None:
        """Until the robot stood, inf where it did not; None where it need not."""
        rig = self._rig
        if fault.wanted == "told":
            rig.until(lambda: rig.told.stopped_s(injected_s) is not None, _PATIENCE_S)
            took_s = rig.told.stopped_s(injected_s)
            return math.inf if took_s is None else took_s
        if fault.wanted == "halted":
            return rig.now_s - injected_s if rig.until(lambda: rig.stands, _PATIENCE_S) else math.inf
        return None
