# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The records of an MCAP file one after the other, as far as they are whole.

mcap's own readers need a file with its end, and take what a torn record still has for all of it.
"""

from __future__ import annotations

import os
import struct
from io import BytesIO
from types import MappingProxyType
from typing import BinaryIO, Iterable, Iterator, Mapping, NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import get_chunk_data_stream

MAGIC = b"\x89MCAP0\r\n"

T = TypeVar("T", bound=McapRecord)
_CONTENT: Mapping[int, type[Schema | Channel | Message]] = MappingProxyType(
    {Opcode.SCHEMA: Schema, Opcode.CHANNEL: Channel, Opcode.MESSAGE: Message}
)

HEAD = struct.Struct("<BQ")


class DamagedError(ValueError):
    """A record whose bytes are not what they were when it was written."""


class Record(NamedTuple):
    """offset: of its first byte in the file, or in the chunk's data. content: behind opcode and length."""

    offset: int
    opcode: int
    content: bytes

    @property
    def end(self) -> int:
        """Offset behind its last byte."""
        return self.offset + HEAD.size + len(self.content)


class _WholeStream(ReadDataStream):
    """mcap's stream, which takes what is left where there is less than was asked for; this one refuses."""

    def read(self, length: int) -> bytes:
        data: bytes = super().read(length)
        if len(data) < length:
            raise EOFError(f"expected {length} bytes, got {len(data)}")
        return data


def read_records(file: BinaryIO, offset: int = len(MAGIC)) -> Iterator[Record]:
    """Every record from an offset on that is there to its last byte; ends before the first that is not."""
    size = file.seek(0, os.SEEK_END)
    while True:
        file.seek(offset)
        head = file.read(HEAD.size)
        if len(head) < HEAD.size:
            return
        opcode, length = HEAD.unpack(head)
        if not opcode or length > size - offset - HEAD.size:  # no record has opcode 0: zeros of a lost page
            return
        record = Record(offset, opcode, file.read(length))
        yield record
        offset = record.end


def parsed(record: Record, kind: type[T]) -> T:
    """A record as mcap has it. Raises DamagedError where it is not exactly what it should be."""
    stream, kind_read = _WholeStream(BytesIO(record.content)), kind.read  # type: ignore[attr-defined]
    length = (len(record.content),) if kind is Message else ()
    try:
        content: T = kind_read(stream, *length)
    except Exception as error:  # mcap, struct and the decoder of texts raise kinds of their own
        raise DamagedError(f"byte {record.offset}: {error}") from error
    if stream.count != len(record.content):
        raise DamagedError(
            f"byte {record.offset}: expected {stream.count} bytes behind the length, got {len(record.content)}"
        )
    return content


def read_content(record: Record) -> Schema | Channel | Message | None:
    """What a chunk may hold; None for every other record. Raises DamagedError."""
    kind = _CONTENT.get(record.opcode)
    return None if kind is None else parsed(record, kind)


def records_of_chunk(chunk: Chunk) -> list[Record]:
    """The records in a chunk, with offsets in its uncompressed data. Raises DamagedError, also by the checksum."""
    try:
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
        data = stream.read(length) if length else b""
    except Exception as error:  # each compression raises kinds of its own
        raise DamagedError(f"chunk: {error}") from error
    records = list(read_records(BytesIO(data), 0))
    if records and records[-1].end != length:
        raise DamagedError(f"chunk: expected records to byte {length}, got them to byte {records[-1].end}")
    return records


def bytes_of(records: Iterable[McapRecord]) -> bytes:
    """Records as they are written."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data
