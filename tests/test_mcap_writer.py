# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is recorded can be read by others, at any moment, and on a full disk up to the last chunk."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

import pytest
from mcap.reader import make_reader

from edgefusion.messages.definitions import definition
from edgefusion.messages.std_msgs import String
from edgefusion.recording.mcap_index import bare_ending
from edgefusion.recording.mcap_survey import survey
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile
from mcap_scenes import START_NS, FullDisk, memory_file, notes, read_by_mcap, write_notes, written


def test_mcaps_own_reader_finds_every_message_by_the_index_and_checksums_hold(tmp_path: Path) -> None:
    messages = written(tmp_path / "a.mcap", 12, per_chunk=5)
    assert read_by_mcap((tmp_path / "a.mcap").open("rb")) == messages


def test_the_summary_counts_what_is_in_the_file(tmp_path: Path) -> None:
    messages = written(tmp_path / "a.mcap", 12, per_chunk=5)
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        only = [m.data for _, _, m in reader.iter_messages("/other")]
    assert only == [note.data for note in messages if note.topic == "/other"]
    assert summary is not None and summary.statistics is not None
    assert summary.statistics.message_count == 12
    assert summary.statistics.channel_message_counts == {1: 6, 2: 6}
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (
        START_NS,
        messages[-1].log_ns,
    )
    assert [len(index.message_index_offsets) for index in summary.chunk_indexes] == [2, 2, 2]
    assert {(s.name, s.encoding, s.data) for s in summary.schemas.values()} == {
        ("std_msgs/msg/String", "ros2msg", definition(String).encode())
    }


def test_a_chunk_that_is_full_is_written_without_being_asked(tmp_path: Path) -> None:
    file = RecordFile.create(tmp_path / "a.mcap")
    writer = McapWriter(file, chunk_bytes=1000)
    channel = writer.add_channel("/mission", "std_msgs/msg/String", "string data")
    before = file.tell()
    writer.write(channel, bytes(999), START_NS, START_NS)
    assert file.tell() == before
    writer.write(channel, bytes(1), START_NS, START_NS)
    assert file.tell() > before + 1000
    writer.close()


def test_an_existing_file_is_replaced_only_when_asked(tmp_path: Path) -> None:
    written(tmp_path / "a.mcap")
    with pytest.raises(FileExistsError):
        RecordFile.create(tmp_path / "a.mcap")
    RecordFile.create(tmp_path / "a.mcap", overwrite=True).close()
    assert (tmp_path / "a.mcap").read_bytes() == b""


def test_on_a_disk_that_fills_at_any_byte_everything_up_to_the_last_chunk_can_be_read(tmp_path: Path) -> None:
    """FAULTS Y1: the file has its end, too, unless the disk fills within the few bytes of an end behind a chunk."""
    messages = notes(6)
    written(tmp_path / "whole.mcap", 6, per_chunk=2)
    size, without_end = (tmp_path / "whole.mcap").stat().st_size, 0
    for room in range(100, size):
        with memory_file() as file:
            with suppress(OSError):
                write_notes(RecordFile(os.dup(file.fileno()), write=FullDisk(room)), messages, 2)
            found = survey(file)
            count = sum(found.index.messages.values())
            assert count % 2 == 0
            assert read_by_mcap(file) == messages[:count] if found.whole else found.end == file.seek(0, os.SEEK_END)
            without_end += not found.whole
    assert count == 6
    assert without_end <= 4 * len(bare_ending())


def test_a_full_disk_is_reported_where_it_cost_messages() -> None:
    with memory_file() as file, pytest.raises(OSError, match="No space left"):
        write_notes(RecordFile(os.dup(file.fileno()), write=FullDisk(600)), notes(6), 2)


def test_the_reserve_stays_free_and_the_recording_ends_well(tmp_path: Path) -> None:
    free = 600_000_000
    path = tmp_path / "a.mcap"
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    file = RecordFile(descriptor, 500_000_000, free_bytes=lambda fd: free - os.fstat(fd).st_size)
    writer = McapWriter(file)
    channel = writer.add_channel("/a", "std_msgs/msg/String", "string data")
    writer.write(channel, bytes(8), START_NS, START_NS)
    writer.flush()
    free = 500_900_000
    with pytest.raises(OSError, match="501 MB are free on the disk, 500 MB are to stay free") as caught:
        writer.write(channel, bytes(1 << 20), START_NS, START_NS)
    assert caught.value.errno == errno.ENOSPC
    writer.close()
    assert [note.data for note in read_by_mcap(path.open("rb"))] == [bytes(8)]
    assert free - path.stat().st_size > 500_000_000


def test_a_file_is_replaced_where_the_disk_has_room_once_it_is_gone_and_else_it_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(os.urandom(4_000_000))
    with pytest.raises(OSError, match="504 MB are free on the disk, 505 MB are to stay free"):
        RecordFile.create(path, 505_000_000, overwrite=True, free_bytes=lambda _: 500_000_000)
    assert path.stat().st_size == 4_000_000
    RecordFile.create(path, 502_000_000, overwrite=True, free_bytes=lambda _: 500_000_000).close()
    assert path.stat().st_size == 0


def test_where_there_is_no_room_no_empty_file_is_left(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="500 MB are to stay free"):
        RecordFile.create(tmp_path / "a.mcap", 500_000_000, free_bytes=lambda _: 500_000_000)
    assert not (tmp_path / "a.mcap").exists()
