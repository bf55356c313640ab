# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""When the LMS2xx measured what it sends: the telegram carries no time, so it is worked out from its arrival."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from edgefusion.drivers.lms2xx_scan import RawScan, range_max_m, ranges_of
from edgefusion.errors import RefusedError
from edgefusion.types import Scan

TURN_NS = 13_333_333
"""The mirror makes 75 turns a second."""

_BITS_PER_BYTE = 10
_PERIODS, _SLACK_S, _LEAST_SILENCE_S = 2.5, 0.05, 0.15
_SCAN_BYTES = 10
"""Of a scan telegram, beside its values."""


def line_ns(size: int, baud: int) -> int:
    """What so many bytes take on a line of 8N1. Raises RefusedError for no speed."""
    if baud < 1:
        raise RefusedError(f"baud: expected at least 1, got {baud}")
    return size * _BITS_PER_BYTE * 1_000_000_000 // baud


def scan_period_s(beams: int, turns: int, baud: int) -> float:
    """From scan to scan: as fast as the mirror or the line, whichever is slower."""
    return max(turns * TURN_NS, line_ns(_SCAN_BYTES + 2 * beams, baud)) / 1e9


def silence_limit_s(beams: int, turns: int, baud: int) -> float:
    """A line that was silent for longer has lost its scanner."""
    return max(_LEAST_SILENCE_S, _PERIODS * scan_period_s(beams, turns, baud))


def scan_age_limit_s(beams: int, turns: int, baud: int) -> float:
    """The newest scan is never older while all is well: the way over the line, the sweep, and two scans that were
    missed, with some slack."""
    line_s = line_ns(_SCAN_BYTES + 2 * beams, baud) / 1e9
    return line_s + turns * TURN_NS / 1e9 + _PERIODS * scan_period_s(beams, turns, baud) + _SLACK_S


def first_byte_ns(received_ns: int, begin: int, received_bytes: int, baud: int) -> int:
    """When a telegram began to arrive, if the stream had so many bytes at that time: those since `begin` came one after
    the other, since the scanner sends without a pause or paused before them."""
    return received_ns - line_ns(received_bytes - begin, baud)


def backlog_ns(waiting: int, size: int, turns: int, baud: int) -> int:
    """How long ago a telegram ended, at least, behind which so many bytes of the next ones of its size have come: one
    begins with every scan that the line can carry. A reader that was held up for a while finds such."""
    period_ns = max(turns * TURN_NS, line_ns(size, baud))
    whole, rest = divmod(waiting, size)
    return whole * period_ns + (period_ns - line_ns(size - rest, baud) if rest else 0)


def mean_wait_ns(size: int, turns: int, baud: int) -> int:
    """From a scan's last beam to its telegram's first byte, on average.

    A mirror that is faster than the line ends a scan at any time; the newest one is sent when the line gets free.
    """
    period_ns = turns * TURN_NS
    return period_ns // 2 if line_ns(size, baud) > period_ns else 0


def beam_times(raw: RawScan) -> npt.NDArray[np.int64]:
    """When each beam was measured, from the middle one's time [ns], int64[n].

    A scan finer than a degree is woven from several turns of the mirror, each a turn later than the one before: beam i
    is of turn i modulo their number.
    """
    beams = np.arange(len(raw.values))
    turn = beams % raw.variant.turns
    times = (beams * raw.angle_increment / (2 * math.pi) + turn) * TURN_NS
    from_middle: npt.NDArray[np.int64] = np.rint(times - times[len(beams) // 2]).astype(np.int64)
    return from_middle


def stamped(raw: RawScan, measuring_mode: int, last_ns: int) -> Scan:
    """The scan in the laser's frame. last_ns: when its last beam had been measured. Raises RefusedError for a mode
    without ranges."""
    dt_ns = beam_times(raw)
    return Scan(
        last_ns - int(dt_ns.max()),
        ranges_of(raw, measuring_mode),
        raw.angle_min,
        raw.angle_increment,
        range_max_m=range_max_m(raw, measuring_mode),
        beam_dt_ns=dt_ns,
    )
