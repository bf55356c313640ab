# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The frames in what a simulated device sends, and how to make one that is well formed and not true."""

from __future__ import annotations

import struct
from typing import Callable, NamedTuple

import numpy as np

from edgefusion.drivers import lms2xx_telegram, sip_frame
from edgefusion.drivers.lms2xx_scan import SCAN
from edgefusion.drivers.sip_status import STATUS_TYPES

Rng = np.random.Generator


class Protocol(NamedTuple):
    """length: of the frame that begins here, 0 where it cannot be told yet. distorted: the same with other contents."""

    length: Callable[[bytes], int]
    distorted: Callable[[bytes, Rng], bytes]


def _sip_length(data: bytes) -> int:
    if not sip_frame.HEADER.startswith(data[:2]):
        return 1
    return 3 + data[2] if len(data) > 2 else 0


def _sip_distorted(packet: bytes, rng: Rng) -> bytes:
    """A report of another place and speed."""
    body = bytearray(packet[3:-2])
    if not body or body[0] not in STATUS_TYPES or len(body) < 11:
        return packet
    struct.pack_into("<HHhhh", body, 1, *rng.integers(0, 0x7FFF, 2), *rng.integers(-1500, 1500, 3))
    return sip_frame.frame(bytes(body))


def _lms_length(data: bytes) -> int:
    if data[0] != lms2xx_telegram.STX or (len(data) > 1 and data[1] not in lms2xx_telegram.FROM_LASER):
        return 1
    if len(data) < 4:
        return 0
    length = lms2xx_telegram.FRAME_BYTES + data[2] + 256 * data[3]
    return length if length <= lms2xx_telegram.MAX_TELEGRAM_BYTES else 1


def _lms_distorted(telegram: bytes, rng: Rng) -> bytes:
    """A scan of other ranges."""
    if len(telegram) < 10 or telegram[4] != SCAN:
        return telegram
    payload = bytearray(telegram[4:-2])
    count = payload[1] + 256 * payload[2] & 0x3FF
    payload[3 : 3 + 2 * count] = rng.integers(50, 8000, count).astype("<u2").tobytes()
    return lms2xx_telegram.encode(bytes(payload), telegram[1])


SIP = Protocol(_sip_length, _sip_distorted)
LMS = Protocol(_lms_length, _lms_distorted)


class Frames:
    """Cuts a stream into frames; bytes between two are frames of their own."""

    def __init__(self, protocol: Protocol) -> None:
        self._protocol, self._begun = protocol, b""

    @property
    def under_way(self) -> bool:
        """Whether one has begun and not ended."""
        return bool(self._begun)

    def rest_of_begun(self, data: bytes) -> int:
        """How many of these bytes, which come next, belong to the one that has begun."""
        begun, count = self._begun, 0
        while begun and count < len(data) and not 0 < self._protocol.length(begun) <= len(begun):
            begun += data[count : count + 1]
            count += 1
        return count

    def feed(self, data: bytes) -> list[bytes]:
        """Those that are whole now."""
        self._begun += data
        whole = []
        while self._begun:
            length = self._protocol.length(self._begun)
            if length == 0 or length > len(self._begun):
                break
            whole.append(self._begun[:length])
            self._begun = self._begun[length:]
        return whole
