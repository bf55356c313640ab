# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated device at the end of a serial line, whatever carries its bytes."""

from __future__ import annotations

from typing import Optional, Protocol

from edgefusion.sim.wire_line import PacedLine


class WireDevice(Protocol):
    """Pure: bytes in, bytes out, the time is passed in. baudrate: the client's; None where any fits, as over TCP."""

    @property
    def line(self) -> PacedLine:
        """Its own end of the line."""

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        """What the client wrote."""

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        """What has left the device by now and was not taken yet, as the client hears it."""
        ...
