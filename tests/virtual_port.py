# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A port without a machine behind it: a simulated device at its end, and a clock that only its reads move on."""

from __future__ import annotations

from typing import Any

import serial

from edgefusion.clock import SimClock
from edgefusion.drivers import link
from edgefusion.drivers.port import READ_S, WRITE_S
from edgefusion.sim.wire_device import WireDevice

_STEP_NS = 2_000_000


class VirtualLine:
    """Where the ports of a test lead. plugged, blocked: what has become of the cable, and of whoever should read.
    step_ns: how exactly the time is known at which something came."""

    def __init__(self, device: WireDevice, clock: SimClock, step_ns: int = _STEP_NS) -> None:
        self.device, self.clock, self.step_ns = device, clock, step_ns
        self.plugged, self.blocked = True, False
        self.openings = 0
        self.written: list[tuple[int, bytes]] = []

    def serve(self, monkeypatch: Any) -> None:
        """From now on every link leads here."""
        monkeypatch.setattr(link, "open_port", self.open)

    def open(self, name: str, baudrate: int) -> VirtualPort:
        self.check(name)
        self.openings += 1
        return VirtualPort(self, baudrate)

    def check(self, name: str = "port") -> None:
        if not self.plugged:
            raise serial.SerialException(f"{name} is gone")

    def pause(self, seconds: float) -> None:
        """For what would sleep."""
        self.clock.advance(round(seconds * 1e9))


class VirtualPort:
    """What a link uses of pyserial's ports."""

    out_waiting = 0

    def __init__(self, line: VirtualLine, baudrate: int) -> None:
        self._line, self.baudrate = line, baudrate
        self._arrived = bytearray()

    def read(self, n: int) -> bytes:
        deadline_ns = self._line.clock() + round(READ_S * 1e9)
        while True:
            self._take()
            if len(self._arrived) >= n or self._line.clock() >= deadline_ns:
                break
            self._line.clock.advance(self._line.step_ns)
        data = bytes(self._arrived[:n])
        del self._arrived[:n]
        return data

    @property
    def in_waiting(self) -> int:
        self._take()
        return len(self._arrived)

    def write(self, data: bytes) -> None:
        self._line.check()
        if self._line.blocked:
            self._line.clock.advance(round(WRITE_S * 1e9))
            raise serial.SerialTimeoutException("nobody reads")
        self._line.written.append((self._line.clock(), bytes(data)))
        self._line.device.receive(data, self.baudrate, self._line.clock())

    def reset_input_buffer(self) -> None:
        self._take()
        self._arrived.clear()

    def reset_output_buffer(self) -> None:
        """All has left."""

    def close(self) -> None:
        """Nobody else wants it."""

    def _take(self) -> None:
        self._line.check()
        self._arrived += self._line.device.transmit(self.baudrate, self._line.clock())
