# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A device on a wire with which something is wrong for a while."""

from __future__ import annotations

from typing import List, Optional, Tuple

import numpy as np

from edgefusion.sim.fault_frames import Frames, Protocol
from edgefusion.sim.faults import Fault
from edgefusion.sim.wire_device import WireDevice
from edgefusion.sim.wire_line import PacedLine

_OF_FRAMES = ("stuck", "wrong", "slow", "intermittent")


class FaultyWire:
    """A WireDevice around another one. now_ns: from when its fault's times count.

    What arrives at the device is spoilt by `off` alone: then it hears nothing. `off` after no more bytes comes at once,
    `garbage` and `delayed` too; all else, and the end of it, waits until no frame is under way.
    """

    def __init__(self, device: WireDevice, protocol: Protocol, fault: Fault, rng: np.random.Generator, now_ns: int):
        self._device, self._protocol, self._fault, self._rng = device, protocol, fault, rng
        self._start_ns = now_ns
        self._left = round(fault.value) if fault.kind == "off" else 0
        self._waits = fault.kind in _OF_FRAMES or self._left > 0
        self._spoils = False
        self._frames = Frames(protocol)
        self._last: bytes = b""
        self._count = 0
        self._late: List[Tuple[int, bytes]] = []

    @property
    def line(self) -> PacedLine:
        """The device's."""
        return self._device.line

    def holds(self, now_ns: int) -> bool:
        """Whether the fault is there now."""
        return self._fault.holds((now_ns - self._start_ns) / 1e9)

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        """What the client wrote."""
        if not (self._fault.kind == "off" and self.holds(now_ns)):
            self._device.receive(data, baudrate, now_ns)

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        """What the client hears."""
        said, holds = self._device.transmit(None, now_ns), self.holds(now_ns)
        before = self._frames.rest_of_begun(said) if self._waits and holds != self._spoils else 0
        heard = self._passed(said[:before], now_ns)
        if not (self._waits and self._frames.under_way):
            self._spoils = holds
        return self.line.heard(heard + self._passed(said[before:], now_ns), baudrate)

    def _passed(self, said: bytes, now_ns: int) -> bytes:
        return self._spoilt(said, now_ns) if self._spoils else self._well(said)

    def _well(self, said: bytes) -> bytes:
        """Keeps the last whole frame: that is what it would be stuck with."""
        for frame in self._frames.feed(said):
            self._last = frame if len(frame) > 1 else self._last
        late = b"".join(data for _, data in self._late)
        self._late.clear()
        return late + said

    def _spoilt(self, said: bytes, now_ns: int) -> bytes:
        kind = self._fault.kind
        if kind == "off":
            cut, self._left = said[: self._left], max(0, self._left - len(said))
            return cut
        if kind == "garbage":
            return self._noisy(said)
        if kind == "delayed":
            return self._delayed(said, now_ns)
        return b"".join(frame if len(frame) == 1 else self._instead(frame) for frame in self._frames.feed(said))

    def _noisy(self, said: bytes) -> bytes:
        data = np.frombuffer(said, np.uint8).copy()
        hit = self._rng.random(len(data)) < self._fault.value
        data[hit] ^= self._rng.integers(1, 256, int(hit.sum()), dtype=np.uint8)
        return data.tobytes()

    def _delayed(self, said: bytes, now_ns: int) -> bytes:
        if said:
            self._late.append((now_ns + round(self._fault.value * 1e9), said))
        due = [data for due_ns, data in self._late if due_ns <= now_ns]
        del self._late[: len(due)]
        return b"".join(due)

    def _instead(self, frame: bytes) -> bytes:
        """What comes instead of a frame."""
        kind = self._fault.kind
        if kind == "stuck":
            self._last = self._last or frame
            return self._last
        if kind == "wrong":
            return self._protocol.distorted(frame, self._rng)
        if kind == "slow":
            self._count += 1
            return frame if self._count % round(self._fault.value) == 0 else b""
        return b"" if self._rng.random() < self._fault.value else frame
