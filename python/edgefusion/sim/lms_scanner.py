# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated LMS200 at the end of its wire: any client of the protocol can read it."""

from __future__ import annotations

from dataclasses import replace
from operator import itemgetter
from typing import List, Optional, Tuple

import numpy as np

from edgefusion.drivers.lms2xx_telegram import ACK, NAK, encode
from edgefusion.drivers.lms2xx_timing import TURN_NS, line_ns
from edgefusion.sim import lms_scanner_telegrams as telegrams
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.lms_scanner_hearing import Hearing
from edgefusion.sim.lms_scanner_scans import Measurement, ScanAt
from edgefusion.sim.lms_scanner_settings import REFUSED, STREAM_ALL, STREAMS, Mode, Settings
from edgefusion.sim.wire_line import PacedLine
from edgefusion.types import Scan

USUAL_BAUD = 9600

_ADDRESS, _POWER_ON_ADDRESS = 0x80, 0x81
_ACK_NS, _REPLY_NS = 2_000_000, 10_000_000
_RESTART_NS, _RESTART_S = 100_000_000, 5.0
_NORMAL, _DAZZLED = 0x10, 0x40


class LmsScanner:
    """A WireDevice. settings: what it is set to. status_byte: at the end of every telegram; a test sets bits for
    pollution or dazzle. covered: as by a hand on its window, it sees nothing.

    left_at: the speed at which an earlier client left it streaming. power_up_s: it is off, and says so when it is on.
    real: what laser it is made of, but for what a client sets.
    """

    def __init__(
        self,
        scan_at: ScanAt,
        now_ns: int = 0,
        left_at: int | None = None,
        power_up_s: float = 0.0,
        real: LaserSpec | None = None,
    ) -> None:
        self._scan_at = scan_at
        self._line = PacedLine(left_at or USUAL_BAUD)
        self.settings = Settings()
        self._measurement = Measurement(self._seen, real or LaserSpec(), self.settings)
        self.status_byte, self.covered = _NORMAL, False
        self._reset(now_ns)
        if left_at:
            self.settings.mode = Mode(STREAM_ALL)
        if power_up_s:
            self.power_cycle(now_ns, power_up_s)

    @property
    def line(self) -> PacedLine:
        """Its own end of the line."""
        return self._line

    @property
    def streaming(self) -> bool:
        """Whether it sends scans without being asked."""
        return self.settings.mode.number in STREAMS

    def power_cycle(self, now_ns: int, off_s: float) -> None:
        """Off for a while; then it says that it is on, at its usual speed, and has forgotten all but its EEPROM."""
        self._line.clear()
        self._line.baudrate = USUAL_BAUD
        self._reset(now_ns)
        self._off_until_ns = now_ns + round(off_s * 1e9)
        said = b"\x90" + telegrams.MODEL + bytes([self.status_byte])
        self._later(self._off_until_ns, encode(said, _POWER_ON_ADDRESS))

    def _reset(self, now_ns: int) -> None:
        self.settings.forget()
        self._restart_ns: int | None = None
        self._waiting: List[Tuple[int, bytes]] = []
        self._hearing = Hearing()
        self._off_until_ns = self._free_ns = self._sent_end_ns = now_ns

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        """What a client wrote; at another speed than its own it hears nothing."""
        if now_ns < self._off_until_ns or baudrate not in (None, self._line.baudrate):
            return
        for command in self._hearing.feed(data, now_ns):
            self._later(now_ns + _ACK_NS, bytes([NAK if command is None else ACK]))
            if command is not None:
                reply, takes_ns = self._reply(command, now_ns)
                self._later(now_ns + takes_ns, encode(reply + bytes([self.status_byte]), _ADDRESS))

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        """What has left by now."""
        if now_ns < self._off_until_ns:
            return b""
        if self.settings.new_speed and not self._waiting and not self._line.busy:  # its answer has left
            self._line.baudrate, self.settings.new_speed = self.settings.new_speed, 0
        self._run(now_ns)
        return self._line.heard(self._line.take(now_ns), baudrate)

    def _run(self, now_ns: int) -> None:
        if self._restart_ns is not None and now_ns >= self._restart_ns:
            self.power_cycle(now_ns, _RESTART_S)
            return
        while self._waiting and self._waiting[0][0] <= now_ns:
            due_ns, telegram = self._waiting.pop(0)
            self._put(telegram, max(due_ns, self._free_ns))
        while self.streaming and not self.settings.new_speed and not self._answers_soon(now_ns):
            end_ns = self._next_end()
            if max(end_ns, self._free_ns) > now_ns:
                return
            self._sent_end_ns = end_ns
            said = self._measurement.streamed(end_ns, self._dazzled) + bytes([self.status_byte])
            self._put(encode(said, _ADDRESS), max(end_ns, self._free_ns))

    def _answers_soon(self, now_ns: int) -> bool:
        """No scan comes between an acknowledgement and its answer."""
        return bool(self._waiting) and self._waiting[0][0] <= now_ns + _REPLY_NS

    def _put(self, telegram: bytes, at_ns: int) -> None:
        self._line.put(telegram, at_ns)
        self._free_ns = at_ns + line_ns(len(telegram), self._line.baudrate)

    def _later(self, due_ns: int, telegram: bytes) -> None:
        """What is due first is sent first: it hears, and answers, while it still writes its memory."""
        self._waiting.append((due_ns, telegram))
        self._waiting.sort(key=itemgetter(0))

    def _next_end(self) -> int:
        """When the scan that is sent next is complete.

        It measures all the time. What is the newest when the line gets free is sent then, if it was not sent before;
        what was completed in between is never sent.
        """
        period_ns = self.settings.turns * TURN_NS
        return max(self._free_ns // period_ns, self._sent_end_ns // period_ns + 1) * period_ns

    @property
    def _dazzled(self) -> bool:
        return bool(self.status_byte & _DAZZLED)

    def _seen(self, stamp_ns: int, spec: LaserSpec) -> Scan:
        scan = self._scan_at(stamp_ns, spec)
        return replace(scan, ranges_m=np.full_like(scan.ranges_m, np.nan)) if self.covered else scan

    def _reply(self, command: bytes, now_ns: int) -> Tuple[bytes, int]:
        if command[0] == 0x10:
            self._restart_ns = now_ns + _RESTART_NS
            return b"\x91", _REPLY_NS
        if command[0] == 0x30:
            known = command == b"\x30\x01"
            return self._measurement.newest(now_ns, self._dazzled) if known else REFUSED, _REPLY_NS
        return self.settings.reply(command, self._line.baudrate)
