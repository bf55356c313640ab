# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The LMS2xx's scan telegram, 0xB0: how many beams, in which unit, of which mirror turn, and the ranges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import read_only

SCAN = 0xB0

_UNITS_M = {0: 0.01, 1: 0.001, 2: 0.1}
_COUNT, _PARTIAL = 0x03FF, 0x2000

# The bits of a value that are the range, by measuring mode; those above are flags.
_RANGE_MASKS = {0: 0x1FFF, 1: 0x1FFF, 2: 0x1FFF, 3: 0x3FFF, 4: 0x3FFF, 5: 0x7FFF, 6: 0x7FFF}
_TOO_FAR = 8
"""So far below the greatest value is the one for "farther than the maximum"; the others above it are no ranges."""


class Variant(NamedTuple):
    """What a full scan covers [degrees], and the angle between its beams [1/100 degree]."""

    angle: int
    resolution: int

    @property
    def turns(self) -> int:
        """Mirror turns that a full scan takes: every turn measures once a degree."""
        return 100 // self.resolution


_FULL = {
    variant.angle * variant.turns + 1: variant
    for variant in (Variant(180, 100), Variant(180, 50), Variant(100, 100), Variant(100, 50), Variant(100, 25))
}
VARIANTS = frozenset(_FULL.values())
"""All that there are."""


@dataclass(frozen=True)
class RawScan:
    """A scan telegram as it came. values: uint16[n], from right to left, flags and all.

    partial: what one mirror turn measured; its first beam is `offset` quarters of a degree after a full scan's.
    """

    values: npt.NDArray[np.uint16]
    unit_m: float
    partial: bool
    offset: int
    status: int

    @property
    def variant(self) -> Variant:
        """Of the whole telegram: a partial scan has its beams a degree apart, like the mirror's turn."""
        return _FULL[len(self.values) | 1]  # a partial scan may lack the last beam, all else is odd

    @property
    def angle_min(self) -> float:
        """Direction of the first beam in the laser's frame [rad]."""
        return float(np.radians(-self.variant.angle / 2 + self.offset / 4))

    @property
    def angle_increment(self) -> float:
        """Angle from beam to beam [rad]."""
        return float(np.radians(self.variant.resolution / 100))


def parse_scan(payload: bytes) -> RawScan:
    """A payload that begins with 0xB0; real-time indices, where configured, are skipped.

    Raises RefusedError for a count of beams, unit or length that no scan has.
    """
    if len(payload) < 4 or payload[0] != SCAN:
        raise RefusedError(f"scan: expected at least 4 bytes from 0xB0 on, got {payload[:4].hex() or 'none'}")
    header = payload[1] + 256 * payload[2]
    count, unit = header & _COUNT, header >> 14
    if len(payload) - 4 - 2 * count not in (0, 1):
        raise RefusedError(f"scan: expected {4 + 2 * count} or {5 + 2 * count} bytes for {count}, got {len(payload)}")
    if unit not in _UNITS_M:
        raise RefusedError(f"scan: expected a unit from 0 to 2, got {unit}")
    offset, partial = header >> 11 & 3, bool(header & _PARTIAL)
    _check_count(count, partial, offset)
    values = np.frombuffer(payload, "<u2", count, offset=3).astype(np.uint16)
    return RawScan(read_only(values), _UNITS_M[unit], partial, offset, payload[-1])


def _check_count(count: int, partial: bool, offset: int) -> None:
    """A partial scan between the whole degrees may lack the last beam."""
    counts = {101, 181} if partial else set(_FULL)
    if offset:
        counts = counts | {100, 180} if partial else set()
    if count not in counts:
        kind = f"{'partial ' if partial else ''}scan at {offset}/4 of a degree"
        raise RefusedError(f"{kind}: expected one of {sorted(counts)} beams, got {count}")


def range_mask(measuring_mode: int) -> int:
    """The bits that are the range. Raises RefusedError for a mode whose values are none that are documented."""
    if measuring_mode not in _RANGE_MASKS:
        raise RefusedError(f"measuring mode: expected 0 to 6, got {measuring_mode}")
    return _RANGE_MASKS[measuring_mode]


def ranges_of(raw: RawScan, measuring_mode: int) -> npt.NDArray[np.float32]:
    """Ranges [m], float32[n]: +inf beyond the maximum, NaN where the scanner does not know."""
    mask = range_mask(measuring_mode)
    values = raw.values & np.uint16(mask)
    ranges_m = (values * raw.unit_m).astype(np.float32)
    ranges_m[values > mask - _TOO_FAR] = np.nan
    ranges_m[values == mask - _TOO_FAR] = np.inf
    return ranges_m


def range_max_m(raw: RawScan, measuring_mode: int) -> float:
    """From here on it sees nothing [m]."""
    return (range_mask(measuring_mode) - _TOO_FAR) * raw.unit_m
