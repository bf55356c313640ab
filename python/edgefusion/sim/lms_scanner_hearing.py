# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a simulated LMS200 takes in what its clients write: telegram after telegram, refused where it is broken."""

from __future__ import annotations

from typing import List, Optional

from edgefusion.drivers.lms2xx_telegram import FRAME_BYTES, MAX_TELEGRAM_BYTES, STX, crc16

_PAUSE_NS = 100_000_000
"""A telegram that pauses for longer is given up: what comes then begins another."""
_HEADER_BYTES = 4


class Hearing:
    """Unlike a client's reader it searches nothing again: what looked like a telegram is answered, if only by a no."""

    def __init__(self) -> None:
        self._begun = bytearray()
        self._heard_ns = 0

    def feed(self, data: bytes, now_ns: int) -> List[Optional[bytes]]:
        """The payloads of the telegrams that are complete with these bytes; None for each that is broken."""
        if now_ns - self._heard_ns > _PAUSE_NS:
            self._begun.clear()
        self._heard_ns = now_ns
        self._begun += data
        found: List[Optional[bytes]] = []
        while True:
            del self._begun[: self._noise()]
            if len(self._begun) < _HEADER_BYTES:
                return found
            size = int.from_bytes(self._begun[2:_HEADER_BYTES], "little") + FRAME_BYTES
            if FRAME_BYTES < size <= MAX_TELEGRAM_BYTES and size > len(self._begun):
                return found
            found.append(_payload(bytes(self._begun[:size])))
            del self._begun[:size]

    def _noise(self) -> int:
        """Bytes before the next telegram's first."""
        begin = self._begun.find(STX)
        return len(self._begun) if begin < 0 else begin


def _payload(telegram: bytes) -> Optional[bytes]:
    good = FRAME_BYTES < len(telegram) <= MAX_TELEGRAM_BYTES
    checksum = int.from_bytes(telegram[-2:], "little")
    return telegram[_HEADER_BYTES:-2] if good and checksum == crc16(telegram[:-2]) else None
