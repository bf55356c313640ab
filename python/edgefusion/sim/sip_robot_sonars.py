# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When which sonar of a simulated Pioneer fires: both rings at once, each of them one after the other."""

from __future__ import annotations

from typing import List

RING = 8
_NS_PER_MS, _USUAL_MS = 1_000_000, 40


class SonarTurns:
    """on: whether they fire at all."""

    def __init__(self, sonars: int, now_ns: int) -> None:
        self._sonars, self._told_ns = sonars, now_ns
        self._rings = [list(range(first, min(first + RING, sonars))) for first in range(0, sonars, RING)]
        self.on, self._slot_ns = True, _USUAL_MS * _NS_PER_MS

    def poll(self, sequence: bytes) -> None:
        """Another order: numbers from 1 on; those of a ring fire in it, as often as they are there. 0 and what is no
        sonar is left out."""
        numbers = [number - 1 for number in sequence if 1 <= number <= self._sonars]
        self._rings = [[each for each in numbers if each // RING == ring] for ring in range(len(self._rings))]

    def set_period(self, period_ms: int) -> None:
        """From one sonar of a ring to the next; 0 and less changes nothing."""
        if period_ms > 0:
            self._slot_ns = period_ms * _NS_PER_MS

    def fired(self, now_ns: int) -> List[int]:
        """The numbers of those that fired since the last time, from 0 on."""
        slots = range(self._told_ns // self._slot_ns, now_ns // self._slot_ns)
        self._told_ns = now_ns
        if not self.on:
            return []
        return sorted({ring[slot % len(ring)] for ring in self._rings if ring for slot in slots[-len(ring) :]})
