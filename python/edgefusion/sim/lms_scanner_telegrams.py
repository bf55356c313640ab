# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated LMS200 says: payloads without their frames, and without the status byte at their end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from edgefusion.drivers.lms2xx_scan import SCAN, Variant, range_mask

MODEL = b"LMS200;30106;V02.10 "
BOOT = b"X01.27 "
MODE_AT, UNIT_AT, AVAILABILITY_AT = 5, 6, 4
REAL_TIME_INDEX = 0x02

_UNITS_M = {0: 0.01, 1: 0.001}
_INVALID, _TOO_FAR, _MOST_BELOW = 0, 8, 9
_BAUD_WORDS = {500000: 0x8001, 38400: 0x8019, 19200: 0x8033, 9600: 0x8067}


@dataclass(frozen=True)
class ScanHeader:
    """What precedes the values. offset: a partial scan's, in quarters of a degree."""

    unit: int
    partial: bool = False
    offset: int = 0

    def word(self, count: int) -> int:
        """The two bytes."""
        return count | self.offset << 11 | 0x2000 * self.partial | self.unit << 14


def scan(ranges_m: npt.NDArray[np.float32], header: ScanHeader, measuring_mode: int) -> bytes:
    """inf, and what is beyond the mode's maximum, is "farther than the maximum"; NaN is "not valid"."""
    mask = range_mask(measuring_mode)
    values = np.rint(np.nan_to_num(ranges_m, nan=0.0, posinf=1e6) / _UNITS_M[header.unit])
    sent = np.where(values > mask - _MOST_BELOW, mask - _TOO_FAR, values)
    sent[np.isnan(ranges_m)] = mask - _INVALID
    return bytes([SCAN]) + header.word(len(sent)).to_bytes(2, "little") + sent.astype("<u2").tobytes()


def status(block: bytes, variant: Variant, mode: int, baudrate: int) -> bytes:
    """The answer to 31."""
    said = bytearray(152)
    said[0] = 0xB1
    said[1:8] = MODEL[13:20]
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
