# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated LMS200 at the end of its wire: any client of the protocol can read it."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional, Tuple

import numpy as np

from edgefusion.drivers.lms2xx_messages import SPEEDS
from edgefusion.drivers.lms2xx_scan import Variant
from edgefusion.drivers.lms2xx_telegram import ACK, NAK, TO_LASER, TelegramReader, encode
from edgefusion.drivers.lms2xx_timing import TURN_NS
from edgefusion.sim import lms_scanner_telegrams as telegrams
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.wire_line import PacedLine
from edgefusion.types import Scan

ScanAt = Callable[[int, LaserSpec], Scan]
"""The scan of such a laser whose middle beam was measured at a time, not longer than a second ago."""

STREAM_ALL, STREAM_PARTIAL, ON_REQUEST, INSTALLATION = 0x24, 0x2A, 0x25, 0x00
USUAL_BAUD = 9600
VARIANTS = (Variant(180, 100), Variant(180, 50), Variant(100, 100), Variant(100, 50), Variant(100, 25))

_ADDRESS, _POWER_ON_ADDRESS = 0x80, 0x81
_ACK_NS, _REPLY_NS, _EEPROM_NS = 2_000_000, 10_000_000, 3_000_000_000
_RESTART_NS, _RESTART_S = 100_000_000, 5.0
_REFUSED = b"\x92"
_PASSWORD = b"SICK_LMS"
_NORMAL = 0x10
_SPEED_OF = {command[1]: baudrate for baudrate, command in SPEEDS.items()}
_MOST_M = 32.0


class LmsScanner:
    """A WireDevice. status_byte: at the end of every telegram; a test sets bits for pollution or dazzle. covered: as by
    a hand on its window, it sees nothing.

    left_at: the speed at which an earlier client left it streaming. power_up_s: it is off, and says so when it is on.
    written: how often its EEPROM was. real: what laser it is made of, but for what a client sets.
    """

    def __init__(
        self,
        scan_at: ScanAt,
        now_ns: int = 0,
        left_at: int | None = None,
        power_up_s: float = 0.0,
        real: LaserSpec | None = None,
    ) -> None:
        self._scan_at, self._real = scan_at, real or LaserSpec()
        self._line = PacedLine(left_at or USUAL_BAUD)
        self.block = telegrams.usual_block()
        self.status_byte, self.written, self.covered = _NORMAL, 0, False
        self._reset(now_ns)
        self._mode = STREAM_ALL if left_at else ON_REQUEST
        if power_up_s:
            self.power_cycle(now_ns, power_up_s)

    @property
    def line(self) -> PacedLine:
        """Its own end of the line."""
        return self._line

    @property
    def streaming(self) -> bool:
        """Whether it sends scans without being asked."""
        return self._mode in (STREAM_ALL, STREAM_PARTIAL)

    def power_cycle(self, now_ns: int, off_s: float) -> None:
        """Off for a while; then it says that it is on, at its usual speed, and has forgotten all but its EEPROM."""
        self._line.clear()
        self._line.baudrate = USUAL_BAUD
        self._reset(now_ns)
        self._off_until_ns = now_ns + round(off_s * 1e9)
        said = bytes([0x90]) + telegrams.MODEL + b" "
        self._later(self._off_until_ns, encode(said + bytes([self.status_byte]), _POWER_ON_ADDRESS))

    def _reset(self, now_ns: int) -> None:
        self.variant = VARIANTS[0]
        self._mode = ON_REQUEST
        self._new_speed: int | None = None
        self._restart_ns: int | None = None
        self._waiting: List[Tuple[int, bytes]] = []
        self._reader = TelegramReader(TO_LASER)
        self._off_until_ns = self._free_ns = self._sent_end_ns = now_ns

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        """What a client wrote; at another speed than its own it hears nothing."""
        if now_ns < self._off_until_ns or baudrate not in (None, self._line.baudrate):
            return
        for item in self._reader.feed(data):
            if item.handshake is None:
                self._answer(item.payload, now_ns)

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        """What has left by now."""
        if now_ns < self._off_until_ns:
            return b""
        if self._new_speed is not None and not self._waiting and not self._line.busy:  # its answer has left
            self._line.baudrate, self._new_speed = self._new_speed, None
        self._run(now_ns)
        return self._line.heard(self._line.take(now_ns), baudrate)

    def _run(self, now_ns: int) -> None:
        if self._restart_ns is not None and now_ns >= self._restart_ns:
            self.power_cycle(now_ns, _RESTART_S)
            return
        while self._waiting and self._waiting[0][0] <= now_ns:
            due_ns, telegram = self._waiting.pop(0)
            self._put(telegram, max(due_ns, self._free_ns))
        while self.streaming and self._new_speed is None:
            end_ns, turn = self._next_end()
            if max(end_ns, self._free_ns) > now_ns:
                return
            self._sent_end_ns = end_ns
            self._put(self._scan(end_ns, turn), max(end_ns, self._free_ns))

    def _put(self, telegram: bytes, at_ns: int) -> None:
        self._line.put(telegram, at_ns)
        self._free_ns = at_ns + len(telegram) * 10 * 1_000_000_000 // self._line.baudrate

    def _later(self, due_ns: int, telegram: bytes) -> None:
        self._waiting.append((due_ns, telegram))

    def _next_end(self) -> Tuple[int, int]:
        """When the scan that is sent next is complete, and the number of its last turn.

        It measures all the time. What is the newest when the line gets free is sent then, if it was not sent before;
        what was completed in between is never sent.
        """
        turns = 1 if self._mode == STREAM_PARTIAL else self.variant.turns
        period_ns = turns * TURN_NS
        number = max(self._free_ns // period_ns, self._sent_end_ns // period_ns + 1)
        return number * period_ns, (number - 1) % self.variant.turns

    def _scan(self, end_ns: int, turn: int) -> bytes:
        partial = self._mode == STREAM_PARTIAL
        spec = self._spec(turn if partial else None)
        scan = self._scan_at(end_ns - _last_beam_ns(spec), spec)
        offset = turn * self.variant.resolution // 25 if partial else 0
        payload = self._scan_payload(scan, partial, offset, end_ns)
        return encode(payload + bytes([self.status_byte]), _ADDRESS)

    def _scan_payload(self, scan: Scan, partial: bool, offset: int, end_ns: int) -> bytes:
        header = telegrams.ScanHeader(self.block[telegrams.UNIT_AT], partial, offset)
        ranges_m = np.full_like(scan.ranges_m, np.nan) if self.covered else scan.ranges_m
        payload = telegrams.scan(ranges_m, header, self.block[telegrams.MODE_AT])
        if self.block[telegrams.AVAILABILITY_AT] & telegrams.REAL_TIME_INDEX:
            payload += bytes([(end_ns // TURN_NS) & 0xFF])
        return payload

    def _spec(self, turn: int | None) -> LaserSpec:
        """The whole scan, or one turn of it: beams a degree apart."""
        angle, resolution = self.variant
        step = 1.0 if turn is not None else resolution / 100
        first = -angle / 2 + (turn or 0) * resolution / 100
        real = self._real
        return LaserSpec(
            beams=int((angle / 2 - first) / step) + 1,
            angle_min=math.radians(first),
            angle_increment=math.radians(step),
            range_max_m=_MOST_M,
            sigma_m=real.sigma_m,
            dropped=real.dropped,
            mixed=real.mixed,
            edge_m=real.edge_m,
            interlaced=turn is None and self.variant.turns > 1,
        )

    def _answer(self, command: bytes, now_ns: int) -> None:
        reply, takes_ns = self._reply(command, now_ns)
        self._later(now_ns + _ACK_NS, bytes([ACK if reply else NAK]))
        if reply:
            self._later(now_ns + takes_ns, encode(reply + bytes([self.status_byte]), _ADDRESS))

    def _reply(self, command: bytes, now_ns: int) -> Tuple[bytes, int]:
        kind = command[0]
        if kind == 0x10:
            self._restart_ns = now_ns + _RESTART_NS
            return b"\x91", _REPLY_NS
        if kind == 0x77:
            return self._write(command[1:])
        answers: Dict[int, Callable[[], bytes]] = {
            0x20: lambda: self._set_mode(command[1:]),
            0x30: lambda: self._one_scan(command, now_ns),
            0x31: lambda: telegrams.status(bytes(self.block), self.variant, self._mode, self._line.baudrate),
            0x32: lambda: b"\xb2",
            0x3A: lambda: b"\xba" + telegrams.MODEL,
            0x3B: lambda: self._set_variant(command),
            0x74: lambda: b"\xf4" + bytes(self.block),
        }
        return (answers[kind]() if kind in answers else _REFUSED), _REPLY_NS

    def _set_mode(self, mode: bytes) -> bytes:
        if mode[:1] == bytes([INSTALLATION]):
            known = mode[1:] == _PASSWORD
            self._mode = INSTALLATION if known else self._mode
            return b"\xa0" + bytes([not known])
        if len(mode) == 1 and mode[0] in _SPEED_OF:
            self._new_speed = _SPEED_OF[mode[0]]
            return b"\xa0\x00"
        if len(mode) == 1 and mode[0] in (STREAM_ALL, STREAM_PARTIAL, ON_REQUEST):
            self._mode = mode[0]
            return b"\xa0\x00"
        return _REFUSED

    def _set_variant(self, command: bytes) -> bytes:
        """A refused one leaves the old; either way it stops streaming."""
        self._mode = ON_REQUEST
        wanted = Variant(int.from_bytes(command[1:3], "little"), int.from_bytes(command[3:5], "little"))
        taken = len(command) == 5 and wanted in VARIANTS
        self.variant = wanted if taken else self.variant
        active = self.variant.angle.to_bytes(2, "little") + self.variant.resolution.to_bytes(2, "little")
        return b"\xbb" + bytes([taken]) + active

    def _one_scan(self, command: bytes, now_ns: int) -> bytes:
        if command[1:] != b"\x01":
            return _REFUSED
        period_ns = self.variant.turns * TURN_NS
        spec = self._spec(None)
        end_ns = now_ns // period_ns * period_ns
        return self._scan_payload(self._scan_at(end_ns - _last_beam_ns(spec), spec), False, 0, end_ns)

    def _write(self, block: bytes) -> Tuple[bytes, int]:
        """Only in installation mode; it takes seconds, and wears the memory out."""
        if self._mode != INSTALLATION or len(block) != len(self.block) or block[telegrams.UNIT_AT] > 1:
            return b"\xf7\x00" + bytes(self.block), _REPLY_NS
        self.block[:] = block
        self.written += 1
        return b"\xf7\x01" + block, _EEPROM_NS


def _last_beam_ns(spec: LaserSpec) -> int:
    """From the middle beam to the last one."""
    from_zero = (spec.beams - 1) * spec.angle_increment / (2 * math.pi)
    middle = spec.beams // 2 * spec.angle_increment / (2 * math.pi) + (spec.beams // 2 % 2 if spec.interlaced else 0)
    last = max(from_zero, (spec.beams - 2) * spec.angle_increment / (2 * math.pi) + 1 if spec.interlaced else 0)
    return math.ceil((last - middle) * spec.turn_ns)
