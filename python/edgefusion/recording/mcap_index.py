# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the end of an MCAP file says of the rest of it, gathered from its records."""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from io import BytesIO

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from edgefusion.recording.mcap_records import (
    MAGIC,
    DamagedError,
    Record,
    bytes_of,
    parsed,
    read_content,
    read_records,
    records_of_chunk,
)

_FOOTER_HEAD = struct.Struct("<BQQQ")
_FOOTER_LENGTH = 8 + 8 + 4


PRIVATE = 0x80
"""From here on, kinds of records are anybody's own."""


class McapIndex:
    """Takes the records of a file's data section in their order; `ending` is what belongs behind them."""

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.messages: Counter[int] = Counter()
        self.first_ns: int | None = None
        self.last_ns = 0
        self._newest: ChunkIndex | None = None
        self._chunks, self._older = 0, bytearray()
        """Of the older ones the records as they are written: as objects they would take seven times the memory."""
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._unindexed: set[int] = set()
        """Channels of the newest chunk whose message index has not come yet."""

    @property
    def lacks_message_indexes(self) -> bool:
        """Whether the newest chunk is not followed by all of its message indexes."""
        return bool(self._unindexed)

    def add(self, record: Record) -> None:
        """One more record. Raises DamagedError where it is not what was written; nothing of it counts then."""
        if record.opcode == Opcode.CHUNK:
            self._add_chunk(record)
        elif record.opcode == Opcode.MESSAGE_INDEX:
            self._add_message_index(record)
        elif record.opcode == Opcode.ATTACHMENT:
            self._add_attachment(record)
        elif record.opcode == Opcode.METADATA:
            name = parsed(record, Metadata).name
            self._metadata.append(MetadataIndex(record.offset, record.end - record.offset, name))
        elif record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
            self._add_content([record])
        elif record.opcode < PRIVATE:
            raise DamagedError(f"byte {record.offset}: no record is of kind {record.opcode} there")

    def add_written(self, data: bytes, offset: int) -> None:
        """Records that stand in the file from an offset on."""
        for record in read_records(BytesIO(data), 0):
            self.add(record._replace(offset=offset + record.offset))

    def forget_message_indexes(self) -> tuple[int, int]:
        """The offsets of the newest chunk and behind it; its message indexes are to come anew."""
        chunk = self._newest
        assert chunk is not None
        chunk.message_index_offsets, chunk.message_index_length = {}, 0
        return chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length

    def ending(self, offset: int) -> bytes:
        """What makes the file whole, from an offset on: the end of its data, the summary, the footer."""
        data_end = bytes_of([DataEnd(0)])
        summary, offsets_at = self._summary(offset + len(data_end))
        start = offset + len(data_end)
        head = _FOOTER_HEAD.pack(Opcode.FOOTER, _FOOTER_LENGTH, start, offsets_at)
        checksum = zlib.crc32(head, zlib.crc32(summary))
        return data_end + summary + bytes_of([Footer(start, offsets_at, checksum)]) + MAGIC

    def _add_chunk(self, record: Record) -> None:
        chunk = parsed(record, Chunk)
        messages = self._add_content(records_of_chunk(chunk))
        stamps_ns = [message.log_time for message in messages]
        self._unindexed = {message.channel_id for message in messages}
        self._older += self._newest_packed()
        self._chunks += 1
        self._newest = ChunkIndex(
            chunk_length=record.end - record.offset,
            chunk_start_offset=record.offset,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            message_end_time=max(stamps_ns, default=0),
            message_index_length=0,
            message_index_offsets={},
            message_start_time=min(stamps_ns, default=0),
            uncompressed_size=chunk.uncompressed_size,
        )

    def _newest_packed(self) -> bytes:
        return b"" if self._newest is None else bytes_of([self._newest])

    def _add_message_index(self, record: Record) -> None:
        channel = parsed(record, MessageIndex).channel_id
        if self._newest is None or channel not in self.channels:
            raise DamagedError(f"byte {record.offset}: an index of channel {channel}, which there is not")
        self._newest.message_index_offsets[channel] = record.offset
        self._newest.message_index_length += record.end - record.offset
        self._unindexed.discard(channel)

    def _add_attachment(self, record: Record) -> None:
        one = parsed(record, Attachment)
        length = record.end - record.offset
        self._attachments.append(
            AttachmentIndex(
                record.offset, length, one.log_time, one.create_time, len(one.data), one.name, one.media_type
            )
        )

    def _add_content(self, records: list[Record]) -> list[Message]:
        """Schemas, channels and messages, the last of which it returns."""
        contents = [read_content(record) for record in records]
        schemas = {content.id: content for content in contents if isinstance(content, Schema)}
        channels = {content.id: content for content in contents if isinstance(content, Channel)}
        messages = [content for content in contents if isinstance(content, Message)]
        unknown = {message.channel_id for message in messages} - set(channels) - set(self.channels)
        if unknown:
            raise DamagedError(f"byte {records[0].offset}: messages of channel {min(unknown)}, which is none")
        for message in messages:
            self.messages[message.channel_id] += 1
            self.first_ns = message.log_time if self.first_ns is None else min(self.first_ns, message.log_time)
            self.last_ns = max(self.last_ns, message.log_time)
        self.schemas.update(schemas)
        self.channels.update(channels)
        return messages

    def _summary(self, start: int) -> tuple[bytes, int]:
        """The summary section that begins at an offset, and where its last part, the offsets, begins."""
        parts = [
            (Opcode.SCHEMA, bytes_of(self.schemas.values())),
            (Opcode.CHANNEL, bytes_of(self.channels.values())),
            (Opcode.STATISTICS, bytes_of([self._statistics()])),
            (Opcode.CHUNK_INDEX, bytes(self._older) + self._newest_packed()),
            (Opcode.ATTACHMENT_INDEX, bytes_of(self._attachments)),
            (Opcode.METADATA_INDEX, bytes_of(self._metadata)),
        ]
        summary, offsets = b"", []
        for opcode, part in parts:
            offsets.append(SummaryOffset(opcode, start + len(summary), len(part)))
            summary += part
        used = [offset for offset in offsets if offset.group_length]
        return summary + bytes_of(used), start + len(summary)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(self.messages),
            chunk_count=self._chunks,
            message_count=sum(self.messages.values()),
            message_end_time=self.last_ns,
            message_start_time=self.first_ns or 0,
            metadata_count=len(self._metadata),
            schema_count=len(self.schemas),
        )


def bare_ending() -> bytes:
    """What makes a file whole where there is no room for a summary."""
    return bytes_of([DataEnd(0), Footer(0, 0, 0)]) + MAGIC
