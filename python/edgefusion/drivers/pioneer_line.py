# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Packets to and from a Pioneer on an open link, each wait with a deadline."""

from __future__ import annotations

from typing import Callable

from edgefusion.clock import Clock
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.sip import Message, SipReader

_BITS_PER_BYTE = 10
_SILENCE_NS, _SOCKET_SILENCE_NS = 40_000_000, 200_000_000
"""After that much an unfinished packet will not end: its count is wrong, and the next packet waits behind it. Adapters
hold bytes back for 16 ms, networks for longer, but they hand on no wrong bytes."""


class RobotError(LinkError):
    """The line is there, but the robot does not answer, or answers otherwise than a Pioneer."""


class PioneerLine:
    """What is said and heard. pause(seconds): sleeps, by default in the caller's real time."""

    def __init__(self, link: Link, clock: Clock, pause: Callable[[float], None]) -> None:
        self.link = link
        self.clock = clock
        self.pause = pause
        self.reader = SipReader()
        self._heard_ns = self._begun_ns = self.message_ns = clock()
        self._begun_bytes = 0

    @property
    def is_socket(self) -> bool:
        """Whether the line has no speed of its own."""
        return "://" in self.link.name

    def send(self, *packets: bytes) -> None:
        """Raises LinkError."""
        self.link.write(b"".join(packets))

    def receive(self) -> list[Message]:
        """What came within 20 ms: a message as soon as it is whole; all that wait, where the reader was held up.

        message_ns tells then when the newest began to leave the robot. Raises LinkError.
        """
        finder = self.reader.finder
        begins = finder.is_between_packets
        data = self.link.read(max(finder.wanted_bytes, self.link.waiting_bytes))
        now_ns = self.clock()
        if not data:
            silence_ns = _SOCKET_SILENCE_NS if self.is_socket else _SILENCE_NS
            return self._stamped(self.reader.give_up()) if now_ns - self._heard_ns >= silence_ns else []
        self._heard_ns = now_ns
        if begins:
            self._begun_ns, self._begun_bytes = now_ns, 0
        self._begun_bytes += len(data)
        return self._stamped(self.reader.feed(data))

    def _stamped(self, messages: list[Message]) -> list[Message]:
        """The first bytes of the newest were there, or it was as long under way as its bytes and what follows take."""
        if messages:
            follow = self.reader.finder.pending_bytes
            size = follow + (self._begun_bytes - follow) // len(messages)
            line_ns = 0 if self.is_socket else size * _BITS_PER_BYTE * 1_000_000_000 // self.link.baudrate
            begun_ns = self._begun_ns if len(messages) == 1 else self._heard_ns
            self.message_ns = min(begun_ns, self._heard_ns - line_ns)
            self._begun_ns, self._begun_bytes = self._heard_ns, follow
        return messages

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
        self.reader.forget()

    def switch(self, baudrate: int, settle_s: float = 0.0) -> None:
        """Changes the host's speed. Raises LinkError, RefusedError for a speed that the port has not."""
        self.link.set_baudrate(baudrate)
        self.drain(settle_s)
