# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Mends MCAP files that end in the middle, as after a power cut: everything up to the damage stays."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from mcap.records import Chunk

from edgefusion.errors import RefusedError
from edgefusion.recording.mcap_chunk import message_indexes, packed_chunk
from edgefusion.recording.mcap_records import DamagedError, bytes_of, parsed, read_records
from edgefusion.recording.mcap_survey import Survey, survey, whole_part_of_torn_chunk
from edgefusion.recording.record_file import RecordFile

MOST_CUT_BYTES = 64 << 20
"""What a power cut can have torn. Behind damage farther from the end there may be much that is well."""


@dataclass(frozen=True)
class Mended:
    """What is in a file now. was_whole: nothing had to be done; cut_bytes: of torn records at its end."""

    was_whole: bool
    messages: int
    duration_ns: int
    cut_bytes: int


def recover(path: Path, most_cut_bytes: int = MOST_CUT_BYTES) -> Mended:
    """Cuts what is torn off a file and writes the end that it lacks; a file that is whole is left as it is.

    Raises RefusedError, and leaves the file as it is, for one that is no MCAP file, or damaged so far from its end that
    more than most_cut_bytes would go.
    """
    try:
        return _recover(path, most_cut_bytes)
    except DamagedError as error:
        raise RefusedError(f"{path}: {error}") from error
    except OSError as error:
        raise RefusedError(f"{path}: cannot be mended: {error.strerror or error}") from error


def _recover(path: Path, most_cut_bytes: int) -> Mended:
    with path.open("rb") as file:
        found = survey(file)
        size = file.seek(0, os.SEEK_END)
        if found.whole:
            return _mended(found, True, 0)
        if size - found.end > most_cut_bytes:
            raise DamagedError(
                f"damaged at byte {found.end}, and {size - found.end} bytes lie behind that would be cut"
            )
        keep, tail = _tail(file, found)
    found.index.add_written(tail, keep)
    _replace_end(path, keep, tail + found.index.ending(keep + len(tail)))
    return _mended(found, False, max(0, size - keep - len(tail)))


def _tail(file: BinaryIO, found: Survey) -> tuple[int, bytes]:
    """Up to which byte the file stays, and what stands behind it instead of what was torn."""
    if found.index.lacks_message_indexes:
        offset, end = found.index.forget_message_indexes()
        (record,) = islice(read_records(file, offset), 1)
        return end, bytes_of(message_indexes(parsed(record, Chunk)))
    data = whole_part_of_torn_chunk(file, found.end)
    return found.end, packed_chunk(data) if data else b""


def _replace_end(path: Path, keep: int, data: bytes) -> None:
    file = RecordFile.open(path)
    try:
        file.cut(keep)
        file.write(data)
        file.sync()
    finally:
        file.close()


def _mended(found: Survey, was_whole: bool, cut_bytes: int) -> Mended:
    index = found.index
    duration_ns = index.last_ns - (index.last_ns if index.first_ns is None else index.first_ns)
    return Mended(was_whole, sum(index.messages.values()), duration_ns, cut_bytes)
