# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Small MCAP files of known content, and what is in a file by the libraries of others."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.reader import make_reader

from edgefusion.messages.cdr import encode
from edgefusion.messages.definitions import definition
from edgefusion.messages.idl import ros_name
from edgefusion.messages.std_msgs import String
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile

START_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000


class Note(NamedTuple):
    """A message as it is in a file."""

    topic: str
    log_ns: int
    data: bytes


def notes(number: int) -> list[Note]:
    """Messages of two topics by turns, each of its own length."""
    return [
        Note(("/mission", "/other")[i % 2], START_NS + i * STEP_NS, encode(String(f"message {i} " + "x" * i)))
        for i in range(number)
    ]


def write_notes(file: RecordFile, messages: list[Note], per_chunk: int) -> None:
    """Writes messages to a file and closes it."""
    writer = McapWriter(file)
    try:
        channels = {
            topic: writer.add_channel(topic, ros_name(String), definition(String)) for topic in ("/mission", "/other")
        }
        for i, note in enumerate(messages):
            writer.write(channels[note.topic], note.data, note.log_ns, note.log_ns, i)
            if (i + 1) % per_chunk == 0:
                writer.flush()
    finally:
        writer.close()


def written(path: Path, number: int = 12, per_chunk: int = 4) -> list[Note]:
    """A new file of so many messages."""
    messages = notes(number)
    write_notes(RecordFile.create(path), messages, per_chunk)
    return messages


def read_by_mcap(file: BinaryIO) -> list[Note]:
    """Every message of a file, in the order of their times, by its index where it has one; closes the file."""
    with file:
        file.seek(0)
        reader = make_reader(file, validate_crcs=True)
        return [Note(channel.topic, m.log_time, m.data) for _, channel, m in reader.iter_messages()]


def memory_file() -> BinaryIO:
    """A file without a disk, whose contents are gone with it."""
    return os.fdopen(os.memfd_create("recording"), "r+b")


class FullDisk:
    """Stands for os.write on a disk that has room for so many bytes."""

    def __init__(self, room: int) -> None:
        self.room = room

    def __call__(self, descriptor: int, data: bytes | memoryview) -> int:
        left = self.room - os.fstat(descriptor).st_size
        if left <= 0:
            raise OSError(28, "No space left on device")
        return os.write(descriptor, data[:left])
