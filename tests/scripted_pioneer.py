# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A small Pioneer, written from the protocol's description alone: deaf and babbling at the wrong speed."""

from __future__ import annotations

import math
import struct
from typing import Optional

from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import PacketFinder, frame
from sip_traces import sip

CYCLE_NS = 100_000_000
BAUDS = (9600, 19200, 38400, 57600, 115200)
IDENTITY = b"\2scripted\0Pioneer\0p3dx-sh\0"
ARGUMENTS = {0x3B: 1, 0x1B: -1}


def config_body(autobaud: int = 2, top_speed_mmps: int = 1000, cycle_ms: int = 100) -> bytes:
    """A CONFIGpac up to its autobaud byte."""
    tops = struct.pack("<B5H", 0, 360, top_speed_mmps, 300, 2000, 500)
    rest = struct.pack("<3B2HB3HB16H6B", cycle_ms, 0, 0, 0, 1, 1, 0, 0, 2000, 0, *[0] * 16, 5, 5, 0, 0, autobaud, 0)
    return b"\x20Pioneer\0p3dx-sh\0S1\0" + tops + b"scripted\0" + rest


class ScriptedPioneer:
    """A wire device; what it is may be set before, what it was told read after: (command, argument) in `told`."""

    def __init__(self, baud: int = 9600) -> None:
        self.baud = self.home = baud
        self.identity, self.config, self.config_checksum = IDENTITY, config_body(), True
        self.stage = 0  # of the handshake; 3: connected, 4: open
        self.motors = self.e_stop = self.deaf_to_enable = self.off = self.mute = False
        self.blocked = self.out_of_step = False
        self.v_mmps = self.w_dps = 0
        self.x_mm = self.y_mm = self.theta = 0.0
        self.counts = 0, 0, 0  # added to what it reports
        self.fields: dict[str, object] = {}  # of the SIPs
        self.told: list[tuple[int, Optional[int]]] = []
        self.say: list[bytes] = []
        self._finder = PacketFinder()
        self._out = bytearray()
        self._sip_ns = self._moved_ns = 0

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        if self.off or baudrate not in (None, self.baud):
            return
        for packet in self._finder.feed(data):
            self._move(now_ns)
            argument = None
            if len(packet.body) == 4:
                argument = ARGUMENTS[packet.body[1]] * int.from_bytes(packet.body[2:], "little")
            self.told.append((packet.type, argument))
            if self.stage >= 3:
                self._obey(packet.type, argument, now_ns)
            else:
                self._handshake(packet.type)

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        if self.off:
            return b""
        for packet in self.say:
            self._out += packet
        self.say = []
        if self.stage == 4 and now_ns - self._sip_ns >= CYCLE_NS:
            self._sip_ns = max(self._sip_ns + CYCLE_NS, now_ns - CYCLE_NS)
            self._move(now_ns)
            self._out += b"" if self.mute else self._status()
        data, self._out = bytes(self._out), bytearray()
        return data if baudrate in (None, self.baud) else bytes(byte ^ 0x5A for byte in data)

    def reset(self) -> None:
        """As after a dip of its power."""
        self.stage, self.baud, self.motors = 0, self.home, False
        self.v_mmps = self.w_dps = 0
        self.x_mm = self.y_mm = self.theta = 0.0

    def kinds(self) -> list[int]:
        """What it was told, without repetitions in a row."""
        numbers = [number for number, _ in self.told]
        return [number for number, before in zip(numbers, [None, *numbers]) if number != before]

    def _handshake(self, number: int) -> None:
        if self.out_of_step:
            self.out_of_step = False
            self._out += frame(b"\xff")
        elif number == self.stage:
            self._out += frame(self.identity if number == 2 else bytes([number]))
            self.stage += 1
        elif number in (0, 1, 2):
            self.stage = 1 if number == 0 else 0
            self._out += frame(bytes([number])) if number == 0 else b""

    def _obey(self, number: int, argument: Optional[int], now_ns: int) -> None:
        if number == Command.OPEN:
            self.stage, self._sip_ns = 4, now_ns
        elif number == Command.CLOSE:
            self.reset()
        elif number == Command.CONFIG and self.config:
            packet = frame(self.config)
            self._out += packet if self.config_checksum else packet[:-1] + bytes([packet[-1] ^ 1])
        elif number == Command.ENABLE:
            self.motors = bool(argument) and not self.deaf_to_enable
        elif number == Command.HOSTBAUD:
            self.baud = BAUDS[argument or 0]
        elif number == Command.VEL:
            self.v_mmps = argument or 0
        elif number == Command.RVEL:
            self.w_dps = argument or 0
        elif number == Command.SETO:
            self.x_mm = self.y_mm = self.theta = 0.0
        elif number in (Command.STOP, Command.E_STOP):
            self.v_mmps = self.w_dps = 0

    @property
    def speeds(self) -> tuple[int, int]:
        return (self.v_mmps, self.w_dps) if self.motors and not self.blocked else (0, 0)

    def _move(self, now_ns: int) -> None:
        dt_s, self._moved_ns = (now_ns - self._moved_ns) / 1e9, now_ns
        v_mmps, w_dps = self.speeds
        self.theta += math.radians(w_dps) * dt_s
        self.x_mm += v_mmps * math.cos(self.theta) * dt_s
        self.y_mm += v_mmps * math.sin(self.theta) * dt_s

    def _status(self) -> bytes:
        v_mmps, w_dps = self.speeds
        aside = round(math.radians(w_dps) / 0.0056)
        heading = round(math.remainder(self.theta, 2 * math.pi) * 4096 / (2 * math.pi))
        x, y, counts = (round(own) + added for own, added in zip((self.x_mm, self.y_mm, heading), self.counts))
        flags = self.motors | self.e_stop << 5
        values = {"left": v_mmps - aside, "right": v_mmps + aside, "flags": flags, **self.fields}
        return sip(x=x & 0x7FFF, y=y & 0x7FFF, heading=counts, **values)
