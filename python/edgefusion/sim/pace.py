# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When a sensor that runs by itself measures, and when what it measured is there."""

from __future__ import annotations

from dataclasses import dataclass

from edgefusion.errors import RefusedError


@dataclass(frozen=True)
class Pace:
    """Stamps first_ns, first_ns + period_ns, ...; a measurement can be had delay_ns after its stamp."""

    first_ns: int
    period_ns: int
    delay_ns: int

    def since(self, after_ns: int, now_ns: int) -> list[int]:
        """The stamps after `after_ns` whose measurements are there now, rising."""
        first = max(0, (after_ns - self.first_ns) // self.period_ns + 1)
        return [self.first_ns + i * self.period_ns for i in range(first, self._done(now_ns))]

    def index(self, stamp_ns: int) -> int:
        """The how-manieth measurement has this stamp, from 0. Raises RefusedError where none has it."""
        index, rest = divmod(stamp_ns - self.first_ns, self.period_ns)
        if index < 0 or rest:
            raise RefusedError(
                f"stamp_ns: expected {self.first_ns} and whole steps of {self.period_ns} from there, got {stamp_ns}"
            )
        return index

    def _done(self, now_ns: int) -> int:
        """How many are there by now."""
        return (now_ns - self.delay_ns - self.first_ns) // self.period_ns + 1
