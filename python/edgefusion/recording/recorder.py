# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Records messages as they come, so that little is lost whatever happens."""

from __future__ import annotations

from typing import Dict

from edgefusion.messages import Message, ros_name
from edgefusion.messages.definitions import definition
from edgefusion.recording.mcap_writer import McapWriter

SYNC_NS = 500_000_000
"""So often what came is on the disk itself. With what comes while it is written, a second is lost at most where that
takes less than 0.4 s; else up to twice what it takes."""

_SEQUENCE_BITS = 32


class Recorder:
    """bytes: how long all that came is together. For one thread.

    Methods raise OSError where the disk takes no more; only `close` is left to call then.
    """

    def __init__(self, writer: McapWriter, now_ns: int, sync_ns: int = SYNC_NS) -> None:
        self._writer, self._sync_ns = writer, sync_ns
        self._synced_ns = now_ns
        self._channels: Dict[str, int] = {}
        self.bytes = 0

    @property
    def messages(self) -> int:
        """How many are in the file."""
        return self._writer.messages

    @property
    def topics(self) -> int:
        """How many there are messages of."""
        return len(self._channels)

    def add(self, topic: str, cls: type[Message], data: bytes, log_ns: int, sequence: int = 0) -> None:
        """A message of a topic, as "/scan", in CDR. log_ns: when it came, since 1970. sequence: its sender's number."""
        if topic not in self._channels:
            self._channels[topic] = self._writer.add_channel(topic, ros_name(cls), definition(cls))
        self._writer.write(self._channels[topic], data, log_ns, log_ns, sequence % (1 << _SEQUENCE_BITS))
        self.bytes += len(data)

    def sync_if_due(self, now_ns: int) -> None:
        """To be called again and again. now_ns: of a clock that only goes forward."""
        if now_ns - self._synced_ns >= self._sync_ns:
            self._writer.sync()
            self._synced_ns = now_ns

    def close(self) -> None:
        """Ends the file."""
        self._writer.close()
