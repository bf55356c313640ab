# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Laser scans of CARMEN logs, the format of the Radish data sets (SICK LMS, text, often gzipped)."""

from __future__ import annotations

import gzip
import math
import zlib
from pathlib import Path
from typing import BinaryIO, Iterator, cast

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Scan

PERIOD_NS = 26_666_667
"""Time between two scans of a SICK LMS: 75 turns a second, every other one half a degree on."""

RANGE_MAX_M = 80.0

_SCAN = b"FLASER "

# Behind the ranges: x y theta, odometry's x y theta, time, host, time of the logger.
_TRAILING_FIELDS = 9

# The log has no angles: these many beams are one degree or half a degree apart, from -90 to +90 degrees.
_BEAMS = (181, 361)


def read_carmen(path: Path) -> Iterator[Scan]:
    """The front laser's scans (FLASER) of a CARMEN log, plain or .gz; every other message is skipped.

    The stamp is made up, number of the scan times PERIOD_NS: the log prints seconds since 1970 with six
    digits, which is useless. No return (81.83 and above: codes of the SICK LMS; the plateau at 51.1) is +inf.

    Raises RefusedError, naming file and line, for a line or a file that is not as described.
    """
    number = 0
    for line_number, line in _lines(path):
        if not line.startswith(_SCAN):
            continue
        try:
            ranges_m = _ranges(line.split())
        except ValueError as error:
            raise RefusedError(f"{path}:{line_number}: {error}") from error
        yield _scan(ranges_m, number * PERIOD_NS)
        number += 1


def count_scans(path: Path) -> int:
    """How many scans `read_carmen` gives of a good log. Raises RefusedError where the file is not whole."""
    return sum(line.startswith(_SCAN) for _, line in _lines(path))


def _lines(path: Path) -> Iterator[tuple[int, bytes]]:
    number = 0
    try:
        with _open(path) as file:
            for number, line in enumerate(file, start=1):
                yield number, line
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise RefusedError(f"{path}:{number + 1}: expected a whole gzip file, got: {error}") from error
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror or error}") from error


def _open(path: Path) -> BinaryIO:
    return cast(BinaryIO, gzip.open(path)) if path.suffix == ".gz" else path.open("rb")


def _ranges(fields: list[bytes]) -> npt.NDArray[np.float64]:
    if len(fields) < 2:
        raise ValueError("FLASER: expected the number of beams, got nothing")
    beams = int(fields[1])
    if beams not in _BEAMS:
        raise ValueError(f"FLASER: expected 181 or 361 beams, got {beams}")
    expected = 2 + beams + _TRAILING_FIELDS
    if len(fields) != expected:
        raise ValueError(f"FLASER: expected {expected} fields for {beams} beams, got {len(fields)}")
    ranges_m = np.array([float(field) for field in fields[2 : 2 + beams]])
    wrong = ~(np.isfinite(ranges_m) & (ranges_m >= 0))
    if wrong.any():
        beam = int(np.argmax(wrong))
        raise ValueError(f"FLASER: expected ranges of 0 m and more, got {ranges_m[beam]} for beam {beam}")
    return ranges_m


def _scan(ranges_m: npt.NDArray[np.float64], stamp_ns: int) -> Scan:
    no_return = (ranges_m > 81.825) | (np.abs(ranges_m - 51.1) < 0.05)
    return Scan(
        stamp_ns=stamp_ns,
        ranges_m=np.where(no_return, np.inf, ranges_m).astype(np.float32),
        angle_min=-math.pi / 2,
        angle_increment=math.pi / (len(ranges_m) - 1),
        range_max_m=RANGE_MAX_M,
    )
