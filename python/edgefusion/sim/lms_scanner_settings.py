# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a simulated LMS200 is set to, and its answers to commands that ask for that or change it."""

from __future__ import annotations

from typing import Callable, Dict, NamedTuple, Tuple

from edgefusion.drivers.lms2xx_messages import SPEEDS
from edgefusion.drivers.lms2xx_scan import VARIANTS, Variant
from edgefusion.sim import lms_scanner_telegrams as telegrams

INSTALLATION, STREAM_ALL, ON_REQUEST, STREAM_MEAN, STREAM_RANGE, STREAM_PARTIAL = 0x00, 0x24, 0x25, 0x26, 0x27, 0x2A
STREAMS = (STREAM_ALL, STREAM_MEAN, STREAM_RANGE, STREAM_PARTIAL)
REFUSED = b"\x92"

_POWER_ON_VARIANT = Variant(180, 100)
_REPLY_NS, _EEPROM_NS = 10_000_000, 3_000_000_000
_PASSWORD = b"SICK_LMS"
_SPEED_OF = {command[1]: baudrate for baudrate, command in SPEEDS.items()}
_MEASURING_MODES, _UNITS, _LEAST_BLOCK = range(7), range(3), 7
_MOST_MEANT_S, _TURN_S = 0.9, 1 / 75


class Mode(NamedTuple):
    """What it does without being asked. mean_of: so many scans are sent as one; first, last: beams, counted from 1."""

    number: int
    mean_of: int = 1
    first: int = 1
    last: int = 0


class Settings:
    """block: its EEPROM. written: how often a client had that written. variant, mode, new_speed: of this session;
    new_speed is the one to change to when it is free, 0 for none."""

    def __init__(self) -> None:
        self.block, self.written = telegrams.usual_block(), 0
        self.forget()

    def forget(self) -> None:
        """As at power-off."""
        self.variant, self.mode, self.new_speed = _POWER_ON_VARIANT, Mode(ON_REQUEST), 0

    @property
    def turns(self) -> int:
        """Of the mirror for a telegram that is streamed."""
        return 1 if self.mode.number == STREAM_PARTIAL else self.variant.turns * self.mode.mean_of

    def reply(self, command: bytes, baudrate: int) -> Tuple[bytes, int]:
        """The payload without the status byte, and how long it takes [ns]. baudrate: the line's."""
        if command[0] == 0x77:
            return self._write(command[1:])
        answers: Dict[int, Callable[[], bytes]] = {
            0x20: lambda: self._set_mode(command[1:]),
            0x31: lambda: telegrams.status(bytes(self.block), self.variant, self.mode.number, baudrate),
            0x32: lambda: b"\xb2",
            0x3A: lambda: b"\xba" + telegrams.MODEL,
            0x3B: lambda: self._set_variant(command[1:]),
            0x74: lambda: b"\xf4" + bytes(self.block),
        }
        return answers.get(command[0], lambda: REFUSED)(), _REPLY_NS

    def _set_mode(self, wanted: bytes) -> bytes:
        if wanted[:1] == bytes([INSTALLATION]):
            known = wanted[1:] == _PASSWORD
            self.mode = Mode(INSTALLATION) if known else self.mode
            return b"\xa0" + bytes([not known])
        if len(wanted) == 1 and wanted[0] in _SPEED_OF:
            self.new_speed = _SPEED_OF[wanted[0]]
            return b"\xa0\x00"
        mode = self._mode_of(wanted)
        if mode is None:
            return REFUSED
        self.mode = mode
        return b"\xa0\x00"

    def _mode_of(self, wanted: bytes) -> Mode | None:
        """None for one that it has not."""
        number, rest = wanted[:1], wanted[1:]
        if number == bytes([STREAM_MEAN]) and len(rest) == 1:
            mean_of = rest[0]
            known = mean_of > 1 and mean_of * self.variant.turns * _TURN_S <= _MOST_MEANT_S
            return Mode(STREAM_MEAN, mean_of) if known else None
        if number == bytes([STREAM_RANGE]) and len(rest) == 4:
            first, last = int.from_bytes(rest[:2], "little"), int.from_bytes(rest[2:], "little")
            known = 1 <= first <= last <= self.variant.angle * self.variant.turns + 1
            return Mode(STREAM_RANGE, 1, first, last) if known else None
        known = wanted in (bytes([n]) for n in (STREAM_ALL, STREAM_PARTIAL, ON_REQUEST))
        return Mode(wanted[0]) if known else None

    def _set_variant(self, wanted: bytes) -> bytes:
        """A refused one leaves the old; either way it stops streaming."""
        self.mode = Mode(ON_REQUEST)
        variant = Variant(int.from_bytes(wanted[:2], "little"), int.from_bytes(wanted[2:4], "little"))
        taken = len(wanted) == 4 and variant in VARIANTS
        self.variant = variant if taken else self.variant
        active = self.variant.angle.to_bytes(2, "little") + self.variant.resolution.to_bytes(2, "little")
        return b"\xbb" + bytes([taken]) + active

    def _write(self, block: bytes) -> Tuple[bytes, int]:
        """Only in installation mode. Clients send the block as long as their own scanner's: what is beyond this one's
        is not kept, and what they leave out stays. It takes seconds where it changes something."""
        known = len(block) >= _LEAST_BLOCK and block[telegrams.MODE_AT] in _MEASURING_MODES
        if self.mode.number != INSTALLATION or not known or block[telegrams.UNIT_AT] not in _UNITS:
            return b"\xf7\x00" + bytes(self.block), _REPLY_NS
        before = bytes(self.block)
        self.block[: len(block)] = block[: len(self.block)]
        self.written += 1
        return b"\xf7\x01" + bytes(self.block), _REPLY_NS if self.block == before else _EEPROM_NS
