# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Torn files are mended: every message that is whole stays, nothing else is in the file, and its end is right."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.writer import CompressionType, IndexType, Writer

from edgefusion.errors import RefusedError
from edgefusion.recording.mcap_records import parsed, read_records, records_of_chunk
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile
from edgefusion.recording.recover import Mended, recover
from mcap_scenes import START_NS, STEP_NS, memory_file, notes, read_by_mcap, write_notes, written


def mended(data: bytes) -> tuple[bytes, Mended]:
    """A file of these bytes once it is mended, and what is said about it."""
    with memory_file() as file:
        file.write(data)
        file.flush()
        found = recover(Path(f"/proc/self/fd/{file.fileno()}"))
        file.seek(0)
        return file.read(), found


def whole_messages(data: bytes, length: int) -> int:
    """How many messages of a file without compression end within so many of its bytes."""
    count = 0
    for record in read_records(BytesIO(data)):
        if record.opcode != Opcode.CHUNK:
            continue
        chunk = parsed(record, Chunk)
        begin = record.end - len(chunk.data)
        for inner in records_of_chunk(chunk):
            count += inner.opcode == Opcode.MESSAGE and begin + inner.end <= length
    return count


def test_cut_at_any_byte_every_message_that_is_whole_stays(tmp_path: Path) -> None:
    messages = written(tmp_path / "a.mcap", 6, per_chunk=2)
    data = (tmp_path / "a.mcap").read_bytes()
    header_end = next(read_records(BytesIO(data))).end
    for length in range(header_end, len(data)):
        content, found = mended(data[:length])
        count = whole_messages(data, length)
        assert (found.was_whole, found.messages) == (False, count)
        assert read_by_mcap(BytesIO(content)) == messages[:count]
    assert count == 6


def test_mending_what_was_cut_behind_the_messages_gives_the_file_as_it_was(tmp_path: Path) -> None:
    written(tmp_path / "a.mcap", 6, per_chunk=2)
    data = (tmp_path / "a.mcap").read_bytes()
    data_end = next(record.offset for record in read_records(BytesIO(data)) if record.opcode == Opcode.DATA_END)
    last_chunk_end = max(record.end for record in read_records(BytesIO(data)) if record.opcode == Opcode.CHUNK)
    for length in range(last_chunk_end, len(data)):
        content, found = mended(data[:length])
        assert content == data
        assert length < data_end or found.cut_bytes == length - data_end


def test_a_whole_file_is_left_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    written(path)
    before = path.stat().st_mtime_ns, path.read_bytes()
    found = recover(path)
    assert (found.was_whole, found.messages, found.duration_ns, found.cut_bytes) == (True, 12, 11 * STEP_NS, 0)
    assert (path.stat().st_mtime_ns, path.read_bytes()) == before


@pytest.fixture(scope="module", params=["none", "lz4", "zstd", "without indexes", "without chunks"])
def by_others(request: pytest.FixtureRequest) -> bytes:
    """A file as other programs write them, with an attachment and metadata between the messages."""
    data = BytesIO()
    compression = {"lz4": CompressionType.LZ4, "zstd": CompressionType.ZSTD}.get(request.param, CompressionType.NONE)
    indexes = IndexType.NONE if request.param == "without indexes" else IndexType.ALL
    writer = Writer(
        data, 120, compression, indexes, use_chunking=request.param != "without chunks", enable_data_crcs=True
    )
    writer.start("ros2", "others")
    channel = writer.register_channel("/mission", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"string data"))
    writer.add_metadata("where", {"room": "laboratory"})
    for i, note in enumerate(notes(6)):
        writer.add_message(channel, note.log_ns, note.data, note.log_ns)
        if i == 2:
            writer.add_attachment(START_NS, START_NS, "note.txt", "text/plain", b"an attachment")
    writer.finish()
    return data.getvalue()


def test_files_of_others_are_mended_wherever_they_are_cut(by_others: bytes) -> None:
    messages, most = [note._replace(topic="/mission") for note in notes(6)], 0
    header_end = next(read_records(BytesIO(by_others))).end
    for length in range(header_end, len(by_others), 3):
        content, found = mended(by_others[:length])
        assert read_by_mcap(BytesIO(content)) == messages[: found.messages]
        assert found.messages >= most
        most = found.messages
    assert most == 6 == mended(by_others)[1].messages


def test_attachments_and_metadata_are_found_again(by_others: bytes) -> None:
    reader = make_reader(BytesIO(mended(by_others[:-1])[0]))
    assert [a.data for a in reader.iter_attachments()] == [b"an attachment"]
    assert [m.metadata for m in reader.iter_metadata()] == [{"room": "laboratory"}]


def test_what_a_power_cut_left_as_zeros_is_cut(tmp_path: Path) -> None:
    messages = written(tmp_path / "a.mcap", 6, per_chunk=2)
    data = (tmp_path / "a.mcap").read_bytes()
    chunks = [record for record in read_records(BytesIO(data)) if record.opcode == Opcode.CHUNK]
    for lost_from in (chunks[2].offset, chunks[2].offset + 100):
        content, found = mended(data[:lost_from] + bytes(len(data) - lost_from))
        assert (found.messages, read_by_mcap(BytesIO(content))) == (4, messages[:4])


def test_damage_far_from_the_end_is_refused_and_the_file_left_as_it_is(tmp_path: Path) -> None:
    written(path := tmp_path / "a.mcap", 6, per_chunk=2)
    data = bytearray(path.read_bytes())
    chunk = next(record for record in read_records(BytesIO(data)) if record.opcode == Opcode.CHUNK)
    data[chunk.end - 1] ^= 1
    path.write_bytes(data[:-1])
    with pytest.raises(RefusedError, match=f"a.mcap: damaged at byte {chunk.offset}, and .* bytes lie behind"):
        recover(path, most_cut_bytes=500)
    assert path.read_bytes() == data[:-1]
    assert recover(path).messages == 0


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r", b"#ROSBAG V2.0\n" + bytes(100), b"\x89MCAP0\r\n\x01\x09"])
def test_what_is_no_mcap_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(RefusedError, match=r"a.mcap: expected an MCAP file"):
        recover(tmp_path / "a.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == content


def test_what_is_being_recorded_is_not_mended_nor_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    writer = McapWriter(RecordFile.create(path))
    before = path.read_bytes()
    with pytest.raises(RefusedError, match=r"a.mcap: cannot be mended: somebody else is recording there"):
        recover(path)
    with pytest.raises(OSError, match="somebody else is recording there"):
        RecordFile.create(path, overwrite=True)
    assert path.read_bytes() == before
    writer.close()
    assert recover(path).was_whole


def test_a_file_that_is_not_there_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=r"a.mcap: cannot be mended: No such file"):
        recover(tmp_path / "a.mcap")


@given(st.data())
def test_whatever_byte_is_wrong_nothing_wrong_is_kept(data: st.DataObject) -> None:
    with memory_file() as whole:
        write_notes(RecordFile(os.dup(whole.fileno())), messages := notes(6), 2)
        whole.seek(0)
        content = bytearray(whole.read())
    header_end = next(read_records(BytesIO(content))).end
    at = data.draw(st.integers(header_end, len(content) - 2))
    content[at] ^= data.draw(st.integers(1, 255))
    content, found = mended(content[:-1])
    kept = [note.data for note in read_by_mcap(BytesIO(content))]
    assert len(kept) == found.messages
    assert kept == [note.data for note in messages[: len(kept)]]


KILLED = """
import sys
from itertools import count
from pathlib import Path
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile

writer = McapWriter(RecordFile.create(Path(sys.argv[1])))
channel = writer.add_channel("/mission", "std_msgs/msg/String", "string data")
for i in count(1):
    writer.write(channel, bytes([i % 256]) * 3000, i, i)
    if i % 50 == 0:
        writer.sync()
        print(i, flush=True)
"""


@pytest.mark.parametrize("syncs", [1, 2, 5])
def test_a_process_that_is_killed_loses_nothing_of_what_it_had_synced(tmp_path: Path, syncs: int) -> None:
    """FAULTS Y2, the writer alone."""
    path = tmp_path / "a.mcap"
    with subprocess.Popen([sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for _ in range(syncs):
            synced = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
    found = recover(path)
    assert found.messages >= synced == 50 * syncs
    assert [(note.log_ns, note.data[0]) for note in read_by_mcap(path.open("rb"))] == [
        (i, i % 256) for i in range(1, found.messages + 1)
    ]
