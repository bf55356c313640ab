# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Questions and answers on an LMS2xx's line, in the midst of what it streams, each with a deadline."""

from __future__ import annotations

import math
from typing import Callable

from edgefusion.clock import Clock
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.lms2xx_messages import NOT_NOW, reply_code
from edgefusion.drivers.lms2xx_telegram import MAX_TELEGRAM_BYTES, NAK, Received, TelegramReader, encode
from edgefusion.drivers.lms2xx_timing import line_ns

TRIES = 3
_SILENCE_NS = 100_000_000
"""After that much an unfinished telegram will not end: no adapter holds bytes back for so long."""
_GAP_BAUD, _GAP_S = 500_000, 60e-6
"""At this speed the scanner wants this pause behind every byte."""


class LaserError(LinkError):
    """The line is there, but the scanner does not answer, says no, or started anew."""


class LaserLine:
    """The telegrams of an open link. pause(seconds): sleeps, by default in the caller's real time."""

    def __init__(self, link: Link, clock: Clock, pause: Callable[[float], None]) -> None:
        self.link = link
        self.reader = TelegramReader()
        self._clock = clock
        self._pause = pause
        self._heard_ns = clock()

    def receive(self) -> tuple[list[Received], int]:
        """What came within 20 ms, and when the reading ended. Raises LinkError."""
        data = self.link.read(self.reader.wanted_bytes)
        now_ns = self._clock()
        if data:
            self._heard_ns = now_ns
            return self.reader.feed(data), now_ns
        return (self.reader.silence() if now_ns - self._heard_ns > _SILENCE_NS else []), now_ns

    def ask(self, command: bytes, answer_s: float, tries: int = TRIES, quiet_s: float = math.inf) -> bytes:
        """The answer's payload; scans that come before it are skipped.

        answer_s: how long the scanner may take for it, beside what the line takes. quiet_s: after so long without a
        single byte nobody is there. Raises LaserError where no answer comes or the scanner says that it cannot now,
        LinkError.
        """
        for _ in range(tries):
            self._send(command)
            payload = self._answer(reply_code(command), answer_s, min(quiet_s, answer_s))
            if payload is not None:
                return payload
        raise LaserError(
            f"{self.link.name}: expected an answer to {command.hex()} at {self.link.baudrate} baud, got none"
        )

    def switch(self, baudrate: int, settle_s: float) -> None:
        """Changes the host's speed; the scanner needs a moment after changing its own. Raises LinkError."""
        self.link.set_baudrate(baudrate)
        self._pause(settle_s)
        self.link.discard_input()
        self.reader = TelegramReader()

    def _send(self, command: bytes) -> None:
        telegram = encode(command)
        if self.link.baudrate < _GAP_BAUD:
            self.link.write(telegram)
            return
        for at in range(len(telegram)):
            self.link.write(telegram[at : at + 1])
            self._pause(_GAP_S)

    def _answer(self, code: int, answer_s: float, quiet_s: float) -> bytes | None:
        """None where the scanner asks for it again, or says nothing in time, or what comes is no telegrams: the speed
        is another then."""
        # Two telegrams: the scan that is under way, and the answer.
        deadline_ns = self._clock() + int(answer_s * 1e9) + 2 * line_ns(MAX_TELEGRAM_BYTES, self.link.baudrate)
        garbage = self.reader.discarded_bytes + 2 * MAX_TELEGRAM_BYTES
        begun_ns = self._heard_ns = self._clock()
        while True:
            found, now_ns = self.receive()
            for item in found:
                if item.handshake == NAK:
                    return None
                if item.handshake is None and item.payload[0] == code:
                    return item.payload
                if item.handshake is None and item.payload[0] == NOT_NOW:
                    raise LaserError(f"{self.link.name}: the scanner refused the command that {code:02x} answers")
            patience_s = quiet_s if self._heard_ns == begun_ns else answer_s
            silent = now_ns - self._heard_ns > patience_s * 1e9
            if silent or now_ns > deadline_ns or self.reader.discarded_bytes > garbage:
                return None
