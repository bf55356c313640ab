# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Simulated devices and the wires that they are at the end of."""

from __future__ import annotations

from typing import Iterable, Protocol, Tuple

from edgefusion.sim.wire_device import WireDevice


class Wire(Protocol):
    """What carries bytes between a device and its client."""

    @property
    def baudrate(self) -> int | None: ...

    def read(self) -> bytes: ...

    def write(self, data: bytes) -> None: ...


class WireServer:
    """Each device may have several wires: all clients hear it, and it hears all."""

    def __init__(self, served: Iterable[Tuple[WireDevice, Tuple[Wire, ...]]]) -> None:
        self._served = list(served)

    def replace(self, number: int, device: WireDevice) -> WireDevice:
        """From now on that device is at the wires of the one with this number. Returns the one before."""
        before, wires = self._served[number]
        self._served[number] = device, wires
        return before

    def rewire(self, number: int, *wires: Wire) -> None:
        """From now on the device with this number is at the end of these."""
        self._served[number] = self._served[number][0], wires

    def pump(self, now_ns: int) -> None:
        """Carries what there is, and never waits: to be called every few milliseconds."""
        for device, wires in self._served:
            for wire in wires:
                data = wire.read()
                if data:
                    device.receive(data, wire.baudrate, now_ns)
            said = device.transmit(None, now_ns)
            if said:
                for wire in wires:
                    wire.write(device.line.heard(said, wire.baudrate))
