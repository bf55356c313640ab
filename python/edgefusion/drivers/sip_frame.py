# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The frame around everything that a Pioneer and its host say to each other, and how it is found in a stream.

FA FB, a count, the body, a checksum (high byte first). The count is that of body and checksum. A body may hold FA FB
itself, and a broken count may claim what follows it: so whatever proves false is searched again from its second byte.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

from edgefusion.errors import RefusedError

HEADER = b"\xfa\xfb"
MAX_BODY_BYTES = 253
_CHECKSUM_BYTES = 2


def checksum(body: bytes) -> int:
    """The sum of the body's big-endian words; a byte that is left over is XORed."""
    words = body[: len(body) & ~1]
    total = (sum(words[::2]) << 8) + sum(words[1::2])
    return (total & 0xFFFF) ^ (body[-1] if len(body) % 2 else 0)


def frame(body: bytes) -> bytes:
    """The packet of a body. Raises RefusedError for one that no packet can hold."""
    if not 1 <= len(body) <= MAX_BODY_BYTES:
        raise RefusedError(f"body: expected 1 to {MAX_BODY_BYTES} bytes, got {len(body)}")
    return HEADER + bytes([len(body) + _CHECKSUM_BYTES]) + body + checksum(body).to_bytes(2, "big")


@dataclass(frozen=True)
class Packet:
    """What was received. body: its first byte is the type. end: the bytes of the stream up to and with it."""

    body: bytes
    end: int
    checksum_holds: bool = True

    @property
    def type(self) -> int:
        return self.body[0]


def believe(body: bytes, checksum_holds: bool) -> bool:
    """The simplest judgement of a packet: its checksum."""
    return checksum_holds


class PacketFinder:
    """Finds the packets in a stream that comes in any pieces. Never keeps more than one unfinished packet.

    judge(body, checksum_holds): whether it is a packet; the additive checksum alone lets one error in some thousand
    pass. skipped_bytes: how many bytes belonged to none.
    """

    def __init__(self, judge: Callable[[bytes, bool], bool] = believe) -> None:
        self._judge = judge
        self._buffer = bytearray()
        self._done = 0  # bytes of the stream before the buffer
        self.skipped_bytes = 0

    @property
    def is_between_packets(self) -> bool:
        """Whether none is under way."""
        return not self._buffer

    @property
    def pending_bytes(self) -> int:
        """How many bytes of the one under way have come."""
        return len(self._buffer)

    @property
    def wanted_bytes(self) -> int:
        """How many bytes the packet under way lacks; before its count is there, those up to it. Whoever reads so many
        gets each packet when its last byte comes."""
        known = len(HEADER) + 1
        return known + (self._buffer[known - 1] if len(self._buffer) >= known else 0) - len(self._buffer)

    def feed(self, data: bytes) -> list[Packet]:
        """The packets that these bytes complete."""
        self._buffer += data
        packets: list[Packet] = []
        position = self._search(packets, 0)
        del self._buffer[:position]
        self._done += position
        return packets

    def give_up(self) -> list[Packet]:
        """The packets inside of an unfinished one: for a line that went silent, where a broken count would wait."""
        packets: list[Packet] = []
        while self._buffer:
            self._drop_first_byte()
            packets += self.feed(b"")
        return packets

    def clear(self) -> None:
        """Forgets an unfinished packet."""
        self._done += len(self._buffer)
        self.skipped_bytes += len(self._buffer)
        self._buffer.clear()

    def _drop_first_byte(self) -> None:
        del self._buffer[0]
        self._done += 1
        self.skipped_bytes += 1

    def _search(self, packets: list[Packet], position: int) -> int:
        """Collects packets from a position on; returns where an unfinished one begins."""
        while True:
            begin = self._header(position)
            self.skipped_bytes += begin - position
            if begin + len(HEADER) >= len(self._buffer):
                return begin
            body_begin = begin + len(HEADER) + 1
            end = body_begin + self._buffer[body_begin - 1]
            if end - body_begin > _CHECKSUM_BYTES:
                if end > len(self._buffer):
                    return begin
                packet = self._packet(body_begin, end)
                if packet is not None:
                    packets.append(packet)
                    position = end
                    continue
            self.skipped_bytes += 1
            position = begin + 1

    def _header(self, position: int) -> int:
        """Where the next header begins, or may yet begin."""
        begin = self._buffer.find(HEADER, position)
        if begin >= 0:
            return begin
        size = len(self._buffer)
        return size - 1 if size > position and self._buffer[-1] == HEADER[0] else size

    def _packet(self, body_begin: int, end: int) -> Packet | None:
        body = bytes(self._buffer[body_begin : end - _CHECKSUM_BYTES])
        found = int.from_bytes(self._buffer[end - _CHECKSUM_BYTES : end], "big")
        holds = checksum(body) == found
        return Packet(body, self._done + end, holds) if self._judge(body, holds) else None
