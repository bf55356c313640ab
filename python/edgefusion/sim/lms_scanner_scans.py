# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated LMS200 measures, in the payloads that it sends it in."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
import numpy.typing as npt

from edgefusion.drivers.lms2xx_timing import TURN_NS
from edgefusion.sim import lms_scanner_telegrams as telegrams
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.lms_scanner_settings import STREAM_MEAN, STREAM_PARTIAL, STREAM_RANGE, Settings
from edgefusion.types import Scan

ScanAt = Callable[[int, LaserSpec], Scan]
"""The scan of such a laser whose middle beam was measured at a time, not longer than a second ago."""

_MOST_M = 32.0


class Measurement:
    """By a laser that is real, but for what its settings say. dazzled: why beams know nothing."""

    def __init__(self, scan_at: ScanAt, real: LaserSpec, settings: Settings) -> None:
        self._scan_at, self._real, self._settings = scan_at, real, settings

    def streamed(self, end_ns: int, dazzled: bool) -> bytes:
        """What is sent without being asked when the mirror has turned for it until then."""
        mode, header = self._settings.mode, self._header(dazzled)
        memory = self._settings.block[telegrams.MODE_AT]
        if mode.number == STREAM_PARTIAL:
            said = self._partial(end_ns, dazzled)
        elif mode.number == STREAM_MEAN:
            period_ns = self._settings.variant.turns * TURN_NS
            scans = [self._ranges(end_ns - number * period_ns) for number in range(mode.mean_of)]
            said = telegrams.mean_scan(np.mean(scans, axis=0), header, memory, mode.mean_of)
        elif mode.number == STREAM_RANGE:
            said = telegrams.part_of_scan(self._ranges(end_ns)[mode.first - 1 : mode.last], header, memory, mode.first)
        else:
            said = telegrams.scan(self._ranges(end_ns), header, memory)
        return said + self._index(end_ns)

    def newest(self, now_ns: int, dazzled: bool) -> bytes:
        """The scan that was complete last."""
        period_ns = self._settings.variant.turns * TURN_NS
        end_ns = now_ns // period_ns * period_ns
        said = telegrams.scan(self._ranges(end_ns), self._header(dazzled), self._settings.block[telegrams.MODE_AT])
        return said + self._index(end_ns)

    def _partial(self, end_ns: int, dazzled: bool) -> bytes:
        turn = (end_ns // TURN_NS - 1) % self._settings.variant.turns
        header = self._header(dazzled, True, turn * self._settings.variant.resolution // 25)
        return telegrams.scan(self._ranges(end_ns, turn), header, self._settings.block[telegrams.MODE_AT])

    def _header(self, dazzled: bool, partial: bool = False, offset: int = 0) -> telegrams.ScanHeader:
        return telegrams.ScanHeader(self._settings.block[telegrams.UNIT_AT], partial, offset, dazzled)

    def _index(self, end_ns: int) -> bytes:
        """Of the mirror's turn, where that is wanted."""
        wanted = self._settings.block[telegrams.AVAILABILITY_AT] & telegrams.REAL_TIME_INDEX
        return bytes([(end_ns // TURN_NS) & 0xFF]) if wanted else b""

    def _ranges(self, end_ns: int, turn: int | None = None) -> npt.NDArray[np.float32]:
        """Of the scan that was complete then, or of that turn of the mirror alone."""
        spec = self._spec(turn)
        return self._scan_at(end_ns - _last_beam_ns(spec), spec).ranges_m

    def _spec(self, turn: int | None) -> LaserSpec:
        """The whole scan, or one turn of it: beams a degree apart."""
        angle, resolution = self._settings.variant
        step = 1.0 if turn is not None else resolution / 100
        first = -angle / 2 + (turn or 0) * resolution / 100
        real = self._real
        return LaserSpec(
            beams=int((angle / 2 - first) / step) + 1,
            angle_min=math.radians(first),
            angle_increment=math.radians(step),
            range_max_m=_MOST_M,
            sigma_m=real.sigma_m,
            dropped=real.dropped,
            mixed=real.mixed,
            edge_m=real.edge_m,
            interlaced=turn is None and self._settings.variant.turns > 1,
        )


def _last_beam_ns(spec: LaserSpec) -> int:
    """From the middle beam to the last one."""
    from_zero = (spec.beams - 1) * spec.angle_increment / (2 * math.pi)
    middle = spec.beams // 2 * spec.angle_increment / (2 * math.pi) + (spec.beams // 2 % 2 if spec.interlaced else 0)
    last = max(from_zero, (spec.beams - 2) * spec.angle_increment / (2 * math.pi) + 1 if spec.interlaced else 0)
    return math.ceil((last - middle) * spec.turn_ns)
