# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated LMS200 says: payloads without their frames, and without the status byte at their end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.drivers.lms2xx_scan import SCAN, Variant, range_mask

MODEL = b"LMS200;301063;V02.10 "
VERSION = MODEL[14:]
BOOT = b"X01.27 "
MODE_AT, UNIT_AT, AVAILABILITY_AT = 5, 6, 4
REAL_TIME_INDEX = 0x02

_UNITS_M = {0: 0.01, 1: 0.001, 2: 0.1}
_INVALID, _DAZZLED, _TOO_FAR, _MOST_BELOW = 0, 1, 8, 9
_BAUD_WORDS = {500000: 0x8001, 38400: 0x8019, 19200: 0x8033, 9600: 0x8067}


@dataclass(frozen=True)
class ScanHeader:
    """What precedes the values. offset: a partial scan's, in quarters of a degree. dazzled: beams know nothing because
    of that."""

    unit: int
    partial: bool = False
    offset: int = 0
    dazzled: bool = False

    def word(self, count: int) -> int:
        """The two bytes."""
        return count | self.offset << 11 | 0x2000 * self.partial | self.unit << 14


def scan(ranges_m: npt.NDArray[np.float32], header: ScanHeader, measuring_mode: int) -> bytes:
    """A whole scan, or a turn of one."""
    return bytes([SCAN]) + values(ranges_m, header, measuring_mode)


def mean_scan(ranges_m: npt.NDArray[np.float32], header: ScanHeader, measuring_mode: int, mean_of: int) -> bytes:
    """The mean of so many scans."""
    return bytes([0xB6, mean_of]) + values(ranges_m, header, measuring_mode)


def part_of_scan(ranges_m: npt.NDArray[np.float32], header: ScanHeader, measuring_mode: int, first: int) -> bytes:
    """Some beams of a scan, from that one on, counted from 1."""
    last = first + len(ranges_m) - 1
    which = first.to_bytes(2, "little") + last.to_bytes(2, "little")
    return b"\xb7" + which + values(ranges_m, header, measuring_mode)


def values(ranges_m: npt.NDArray[np.float32], header: ScanHeader, measuring_mode: int) -> bytes:
    """Their number and unit, and they. inf, and what is beyond the mode's maximum, is "farther than the maximum"; NaN
    is "not valid", or "dazzled"."""
    mask = range_mask(measuring_mode)
    counted = np.rint(np.nan_to_num(ranges_m, nan=0.0, posinf=1e6) / _UNITS_M[header.unit])
    sent = np.where(counted > mask - _MOST_BELOW, mask - _TOO_FAR, counted)
    sent[np.isnan(ranges_m)] = mask - (_DAZZLED if header.dazzled else _INVALID)
    return header.word(len(sent)).to_bytes(2, "little") + sent.astype("<u2").tobytes()


def status(block: bytes, variant: Variant, mode: int, baudrate: int) -> bytes:
    """The answer to 31."""
    said = bytearray(1 + 152)
    said[0] = 0xB1
    said[1:8] = VERSION
    said[8] = mode
    said[18] = variant.angle
    for at in range(19, 51, 2):
        said[at : at + 2] = (1000).to_bytes(2, "little")
    said[67:69] = (4500 // 60).to_bytes(2, "little")
    said[102] = block[MODE_AT]
    said[107:111] = variant.angle.to_bytes(2, "little") + variant.resolution.to_bytes(2, "little")
    said[116:118] = _BAUD_WORDS[baudrate].to_bytes(2, "little")
    said[122], said[123] = block[UNIT_AT], 1
    said[124:131] = BOOT
    return bytes(said)


def usual_block() -> bytearray:
    """The EEPROM as delivered: mode 0, millimetres."""
    block = bytearray(32)
    block[2] = 70
    block[UNIT_AT] = 1
    return block
