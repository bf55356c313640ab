# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Packets to and from a Pioneer on an open link, each wait with a deadline."""

from __future__ import annotations

from typing import Callable

from edgefusion.clock import Clock
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.sip import Message, SipReader

_READ_BYTES = 256
_SILENCE_NS = 100_000_000
"""After that much an unfinished packet will not end."""


class RobotError(LinkError):
    """The line is there, but the robot does not answer, or answers otherwise than a Pioneer."""


class PioneerLine:
    """What is said and heard. pause(seconds): sleeps, by default in the caller's real time."""

    def __init__(self, link: Link, clock: Clock, pause: Callable[[float], None]) -> None:
        self.link = link
        self.clock = clock
        self.pause = pause
        self.reader = SipReader()
        self._heard_ns = clock()

    def send(self, *packets: bytes) -> None:
        """Raises LinkError."""
        self.link.write(b"".join(packets))

    def receive(self) -> list[Message]:
        """What came within 20 ms. Raises LinkError."""
        data = self.link.read(_READ_BYTES)
        if data:
            self._heard_ns = self.clock()
            return self.reader.feed(data)
        return self.reader.give_up() if self.clock() - self._heard_ns > _SILENCE_NS else []

    def first(self, wanted: Callable[[Message], bool], within_s: float) -> Message | None:
        """The first message of a kind; those before it are skipped. None where none comes in time. Raises LinkError."""
        deadline_ns = self.clock() + round(within_s * 1e9)
        while True:
            for message in self.receive():
                if wanted(message):
                    return message
            if self.clock() > deadline_ns:
                return None

    def drain(self, for_s: float) -> None:
        """Lets pass what is still on its way, for a while, and forgets it. Raises LinkError."""
        self.pause(for_s)
        self.link.discard_input()
        self.reader = SipReader()

    def switch(self, baudrate: int, settle_s: float = 0.0) -> None:
        """Changes the host's speed. Raises LinkError, RefusedError for a speed that the port has not."""
        self.link.set_baudrate(baudrate)
        self.drain(settle_s)
