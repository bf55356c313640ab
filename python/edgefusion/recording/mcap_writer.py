# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Writes MCAP files of ROS 2 messages that are readable up to the last chunk at any moment."""

from __future__ import annotations

from mcap.records import Channel, Header, McapRecord, Message, Schema

from edgefusion import __version__
from edgefusion.recording.mcap_chunk import packed_chunk
from edgefusion.recording.mcap_index import McapIndex, bare_ending
from edgefusion.recording.mcap_records import MAGIC, bytes_of
from edgefusion.recording.record_file import RecordFile

CHUNK_BYTES = 1 << 20


class McapWriter:
    """Messages wait in memory until their chunk is full or `flush` is called; a chunk reaches the file wholly, with
    its message indexes, or not at all.

    Every method raises OSError where the disk takes no more: the file ends with the last chunk then, and only
    `close` is left to call.
    """

    def __init__(self, file: RecordFile, chunk_bytes: int = CHUNK_BYTES) -> None:
        self._file, self._chunk_bytes = file, chunk_bytes
        self._index = McapIndex()
        self._schemas: dict[str, Schema] = {}
        self._channels = 0
        self._waiting: list[McapRecord] = []
        self._waiting_bytes = 0
        file.write(MAGIC + bytes_of([Header("ros2", f"edgefusion {__version__}")]))

    @property
    def messages(self) -> int:
        """How many are in the file; those that wait are not."""
        return sum(self._index.messages.values())

    def add_channel(self, topic: str, type_name: str, definition: str) -> int:
        """A topic, as "/scan", with its type, as "sensor_msgs/msg/LaserScan", and that type's .msg text with all that
        it needs. Returns the number that `write` takes."""
        if type_name not in self._schemas:
            schema = Schema(len(self._schemas) + 1, definition.encode(), "ros2msg", type_name)
            self._schemas[type_name] = schema
            self._waiting.append(schema)
        self._channels += 1
        self._waiting.append(Channel(self._channels, topic, "cdr", {}, self._schemas[type_name].id))
        return self._channels

    def write(self, channel: int, data: bytes, log_ns: int, publish_ns: int, sequence: int = 0) -> None:
        """A message, CDR with its 4-byte header. log_ns: when it came, publish_ns: when it was sent, since 1970."""
        self._waiting.append(Message(channel, log_ns, data, publish_ns, sequence))
        self._waiting_bytes += len(data)
        if self._waiting_bytes >= self._chunk_bytes:
            self.flush()

    def flush(self) -> None:
        """Writes the chunk that waits, if it has messages."""
        if not self._waiting_bytes:
            return
        chunk = packed_chunk(bytes_of(self._waiting))
        self._waiting, self._waiting_bytes = [], 0
        offset = self._file.tell()
        self._file.write(chunk)
        self._index.add_written(chunk, offset)

    def sync(self) -> None:
        """Writes what waits; it is on the disk itself then."""
        self.flush()
        self._file.sync()

    def close(self) -> None:
        """Writes what waits and ends the file with its summary, or without where there is no room for one.

        Raises OSError where something could not be written; `edgefusion recover` mends a file without an end.
        """
        try:
            try:
                self.flush()
            finally:
                self._end()
        finally:
            self._file.close()

    def _end(self) -> None:
        self._file.give_up_reserve()
        try:
            self._file.write(self._index.ending(self._file.tell()))
        except OSError:
            self._file.write(bare_ending())
        self._file.sync()
