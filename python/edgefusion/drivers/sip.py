# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Everything that a Pioneer says, out of its bytes."""

from __future__ import annotations

from typing import Callable, Union

from edgefusion.drivers.sip_config import CONFIG_TYPE, RobotConfig, read_config
from edgefusion.drivers.sip_frame import Packet, PacketFinder
from edgefusion.drivers.sip_status import STATUS_TYPES, Status, read_status
from edgefusion.errors import RefusedError

Message = Union[Status, RobotConfig, Packet]
"""What a packet says; a reply of the handshake is the packet itself."""

REPLIES = frozenset({0x00, 0x01, 0x02, 0xFF})
"""Types of the replies of the handshake."""


def is_packet(body: bytes, checksum_holds: bool) -> bool:
    """Whether to believe a packet. Real robots send the CONFIGpac with a wrong checksum: there its content decides."""
    if body[0] == CONFIG_TYPE:
        return _reads(read_config, body)
    return checksum_holds and (body[0] not in STATUS_TYPES or _reads(read_status, body))


class SipReader:
    """A stream of bytes in, messages out. unknown_packets: how many of types that a base does not need came."""

    def __init__(self) -> None:
        self.finder = PacketFinder(is_packet)
        self.unknown_packets = 0

    def feed(self, data: bytes) -> list[Message]:
        """The messages that these bytes complete; those of unknown types are skipped and counted."""
        return self._messages(self.finder.feed(data))

    def give_up(self) -> list[Message]:
        """The messages inside of an unfinished packet, for a line that went silent."""
        return self._messages(self.finder.give_up())

    def forget(self) -> None:
        """Drops an unfinished packet: what comes next is from another time, or of another speed."""
        self.finder.clear()

    def _messages(self, packets: list[Packet]) -> list[Message]:
        messages = []
        for packet in packets:
            message = _message(packet)
            if message is None:
                self.unknown_packets += 1
            else:
                messages.append(message)
        return messages


def _message(packet: Packet) -> Message | None:
    if packet.type in STATUS_TYPES:
        return read_status(packet.body)
    if packet.type == CONFIG_TYPE:
        return read_config(packet.body)
    return packet if packet.type in REPLIES else None


def _reads(read: Callable[[bytes], object], body: bytes) -> bool:
    try:
        read(body)
    except RefusedError:
        return False
    return True
