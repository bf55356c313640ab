# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A chunk of an MCAP file with the message indexes that belong behind it."""

from __future__ import annotations

import zlib

from mcap.records import Chunk, McapRecord, Message, MessageIndex

from edgefusion.recording.mcap_records import bytes_of, read_content, records_of_chunk


def packed_chunk(data: bytes) -> bytes:
    """Records one after the other, of schemas, channels and at least one message, as a chunk. Raises DamagedError.

    Not compressed: what fills a recording are JPEGs, and a torn chunk still has its first messages.
    """
    bare = _chunk(data, 0, 0)
    indexes = message_indexes(bare)
    stamps_ns = [stamp_ns for index in indexes for stamp_ns, _ in index.records]
    records: list[McapRecord] = [_chunk(data, min(stamps_ns), max(stamps_ns)), *indexes]
    return bytes_of(records)


def message_indexes(chunk: Chunk) -> list[MessageIndex]:
    """Where in a chunk each channel's messages are. Raises DamagedError."""
    found: dict[int, MessageIndex] = {}
    for record in records_of_chunk(chunk):
        message = read_content(record)
        if isinstance(message, Message):
            index = found.setdefault(message.channel_id, MessageIndex(message.channel_id, []))
            index.records.append((message.log_time, record.offset))
    return list(found.values())


def _chunk(data: bytes, first_ns: int, last_ns: int) -> Chunk:
    return Chunk(
        compression="",
        data=data,
        message_start_time=first_ns,
        message_end_time=last_ns,
        uncompressed_crc=zlib.crc32(data),
        uncompressed_size=len(data),
    )
