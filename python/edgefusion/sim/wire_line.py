# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The line of a simulated device: it takes its time, and at another speed everything arrives as noise."""

from __future__ import annotations

from edgefusion.drivers.lms2xx_timing import line_ns

_NOISE = bytes((37 * byte + 101) % 256 for byte in range(256))


class PacedLine:
    """Bytes leave one after the other, at the line's speed, as eight bits with a start and a stop."""

    def __init__(self, baudrate: int) -> None:
        self.baudrate = baudrate
        self._waiting = bytearray()
        self._begin_ns = 0

    @property
    def busy(self) -> bool:
        """Whether something has not left yet."""
        return bool(self._waiting)

    def put(self, data: bytes, now_ns: int) -> None:
        """Something to send, as soon as what waits before it has left."""
        if not self._waiting:
            self._begin_ns = now_ns
        self._waiting += data

    def take(self, now_ns: int) -> bytes:
        """What has left since the last time."""
        byte_ns = line_ns(1, self.baudrate)
        count = min(len(self._waiting), max(0, now_ns - self._begin_ns) // byte_ns)
        gone = bytes(self._waiting[:count])
        del self._waiting[:count]
        self._begin_ns += count * byte_ns
        return gone

    def clear(self) -> None:
        """What waits is lost."""
        self._waiting.clear()

    def heard(self, data: bytes, baudrate: int | None) -> bytes:
        """The same bytes where both ends have one speed, noise where they have not."""
        return data if baudrate in (None, self.baudrate) else data.translate(_NOISE)
