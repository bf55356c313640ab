# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The frame around everything that a SICK LMS2xx and its host say to each other, and how it is found in a stream.

STX, address, length of the payload (little-endian), payload, CRC (little-endian). Between telegrams the scanner
sends one byte, ACK or NAK, for each telegram that it got.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Container

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError

STX, ACK, NAK = 0x02, 0x06, 0x15
MAX_TELEGRAM_BYTES = 812
FRAME_BYTES = 6
"""What a telegram has around its payload: a header of four bytes and the CRC."""

TO_LASER = frozenset(range(0x00, 0x80))
FROM_LASER = frozenset(range(0x80, 0x85))
"""0x80 + the scanner's address: 0x81 carries what it says by itself after power-on."""

_HEADER_BYTES = 4
_GARBAGE_BYTES = 64


def _weights() -> npt.NDArray[np.uint16]:
    """What a byte of each value is in the checksum, by how many bytes follow it: [MAX_TELEGRAM_BYTES, 256].

    With every byte that follows, the checksum is shifted by a bit, modulo the polynomial; a byte is added to it when it
    comes, and, shifted by eight, once more with the next one.
    """
    weights = np.empty((MAX_TELEGRAM_BYTES, 256), np.uint16)
    weights[0] = np.arange(256)
    shifted = _shifted(weights[0]) ^ weights[0] << 8
    for row in weights[1:]:
        row[:] = shifted
        shifted = _shifted(shifted)
    return weights


def _shifted(values: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint16]:
    return (values << 1 ^ np.where(values & 0x8000, 0x8005, 0)).astype(np.uint16)


_WEIGHTS, _FOLLOWING = _weights(), np.arange(MAX_TELEGRAM_BYTES)[::-1]


def crc16(data: bytes) -> int:
    """The checksum over STX to the end of the payload; of MAX_TELEGRAM_BYTES at most."""
    following = _FOLLOWING[MAX_TELEGRAM_BYTES - len(data) :]
    return int(np.bitwise_xor.reduce(_WEIGHTS[following, np.frombuffer(data, np.uint8)]))


def encode(payload: bytes, address: int = 0x00) -> bytes:
    """The telegram of a payload. Raises RefusedError for one that no telegram can hold."""
    if not 1 <= len(payload) <= MAX_TELEGRAM_BYTES - FRAME_BYTES:
        raise RefusedError(f"payload: expected 1 to {MAX_TELEGRAM_BYTES - FRAME_BYTES} bytes, got {len(payload)}")
    if not 0 <= address <= 0xFF:
        raise RefusedError(f"address: expected 0 to 255, got {address}")
    body = bytes([STX, address]) + len(payload).to_bytes(2, "little") + payload
    return body + crc16(body).to_bytes(2, "little")


@dataclass(frozen=True)
class Received:
    """A telegram whose checksum was right, or the one byte of an ACK or NAK: address -1 then.

    begin, end: where it lay in the stream, counted in bytes since its first one.
    """

    address: int
    payload: bytes
    begin: int
    end: int

    @property
    def handshake(self) -> int | None:
        """ACK or NAK, None of a telegram."""
        return self.payload[0] if self.address < 0 else None


class TelegramReader:
    """Finds telegrams in a stream that comes in pieces of any size, and goes on after anything else.

    A header that turns out false costs its own first byte: what lies behind it is searched again. Never holds more than
    a telegram that is not complete. ACK and NAK count only right behind a telegram, another one of them or silence:
    in the midst of garbage the same bytes say nothing.
    """

    def __init__(self, addresses: Container[int] = FROM_LASER) -> None:
        self._addresses = addresses
        self._pending = bytearray()
        self._offset = 0  # of the first pending byte
        self._clean = True
        self.discarded_bytes = 0

    @property
    def pending_bytes(self) -> int:
        """How many bytes wait for the rest of their telegram."""
        return len(self._pending)

    @property
    def wanted_bytes(self) -> int:
        """How many bytes complete what is begun, as far as it can be told: who reads just as many, and no more, knows
        when the last of them came. In the midst of garbage, some more than one: reading it must not cost a core."""
        if self._pending:
            return self._length_at(0) - len(self._pending)
        return 1 if self._clean else _GARBAGE_BYTES

    @property
    def received_bytes(self) -> int:
        """How many bytes the stream has had so far."""
        return self._offset + len(self._pending)

    def feed(self, data: bytes) -> list[Received]:
        """What is complete with these bytes, in order."""
        self._pending += data
        return self._search(silent=False)

    def silence(self) -> list[Received]:
        """What is complete now that nothing follows: an unfinished telegram will not end, but may hide others."""
        found = self._search(silent=True)
        self._clean = True
        return found

    def _search(self, silent: bool) -> list[Received]:
        found: list[Received] = []
        data, at = self._pending, 0
        while at < len(data):
            length = self._length_at(at)
            if length > len(data) - at and not silent:
                break
            received = self._received_at(at, length)
            if received is None:
                self._clean = False
                self.discarded_bytes += 1
                at += 1
            else:
                self._clean = True
                found.append(received)
                at += length
        self._offset += at
        del data[:at]
        return found

    def _length_at(self, at: int) -> int:
        """Bytes of what begins here, as far as it can be told: the header alone while that is not complete; 1 for what
        begins no telegram."""
        data = self._pending
        if data[at] != STX or (len(data) > at + 1 and data[at + 1] not in self._addresses):
            return 1
        if len(data) < at + _HEADER_BYTES:
            return _HEADER_BYTES
        length = data[at + 2] + 256 * data[at + 3] + FRAME_BYTES
        return length if FRAME_BYTES < length <= MAX_TELEGRAM_BYTES else 1

    def _received_at(self, at: int, length: int) -> Received | None:
        data, begin = self._pending, self._offset + at
        if length == 1:
            handshake = self._clean and data[at] in (ACK, NAK)
            return Received(-1, bytes(data[at : at + 1]), begin, begin + 1) if handshake else None
        telegram = bytes(data[at : at + length])
        if len(telegram) < length or int.from_bytes(telegram[-2:], "little") != crc16(telegram[:-2]):
            return None
        return Received(telegram[1], telegram[_HEADER_BYTES:-2], begin, begin + length)
