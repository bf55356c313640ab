# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How far an MCAP file is whole."""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from io import BytesIO
from itertools import takewhile
from typing import BinaryIO, Iterator

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, Header

from edgefusion.recording.mcap_index import McapIndex
from edgefusion.recording.mcap_records import (
    HEAD,
    MAGIC,
    DamagedError,
    Record,
    parsed,
    read_content,
    read_records,
)

_FOOTER = struct.Struct("<BQQQI")


@dataclass(frozen=True)
class Survey:
    """index: of everything that is whole. end: the offset behind its last record. whole: the file has its own end."""

    index: McapIndex
    end: int
    whole: bool


def survey(file: BinaryIO) -> Survey:
    """Reads a file up to its end or to the first damage. Raises DamagedError where it is no MCAP file at all."""
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise DamagedError("expected an MCAP file, got one that does not begin like it")
    records = read_records(file)
    index, end = McapIndex(), _header_end(records)
    for record in records:
        if record.opcode == Opcode.DATA_END:
            return Survey(index, end, is_ended(file))
        try:
            index.add(record)
        except DamagedError:
            break
        end = record.end
    return Survey(index, end, False)


def _header_end(records: Iterator[Record]) -> int:
    header = next(records, None)
    if header is None or header.opcode != Opcode.HEADER:
        raise DamagedError("expected an MCAP file, got one that ends or is damaged in its first record")
    parsed(header, Header)
    return header.end


def is_ended(file: BinaryIO) -> bool:
    """Whether a file ends as it should, with a summary that is as it was written, or with none."""
    size = file.seek(0, os.SEEK_END)
    at = size - len(MAGIC) - _FOOTER.size
    file.seek(max(0, at))
    tail = file.read()
    if at < len(MAGIC) or tail[_FOOTER.size :] != MAGIC:
        return False
    opcode, length, start, _, checksum = _FOOTER.unpack_from(tail)
    if opcode != Opcode.FOOTER or length != _FOOTER.size - HEAD.size or start > at:
        return False
    file.seek(start or at)
    summary = file.read(at - (start or at)) + tail[: _FOOTER.size - 4]
    return not checksum or checksum == zlib.crc32(summary)


def whole_part_of_torn_chunk(file: BinaryIO, offset: int) -> bytes:
    """The records that are whole in the chunk with which a file breaks off, where it is not compressed."""
    file.seek(offset)
    head, content = file.read(HEAD.size), file.read()
    if len(head) < HEAD.size:
        return b""
    opcode, length = HEAD.unpack(head)
    if opcode != Opcode.CHUNK or len(content) >= length:
        return b""
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))  # with what there is of its data
    except (McapError, struct.error, UnicodeDecodeError):
        return b""
    whole = list(takewhile(_is_whole, read_records(BytesIO(chunk.data), 0))) if not chunk.compression else []
    if not any(record.opcode == Opcode.MESSAGE for record in whole):
        return b""
    data: bytes = chunk.data[: whole[-1].end]
    return data


def _is_whole(record: Record) -> bool:
    try:
        return read_content(record) is not None
    except DamagedError:
        return False
