# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A recorder that runs for days stays small: its file's end is gathered in a few hundred bytes for each chunk."""

from __future__ import annotations

import gc
import tracemalloc
from pathlib import Path

from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile
from mcap_scenes import START_NS

CHANNELS = 16
CHUNK_BYTES = 400
"""As a file takes for its index: a record of 80 bytes, and 10 for each channel, grown by doubling at worst."""


def test_each_chunk_costs_as_much_memory_as_its_index_takes_in_the_file(tmp_path: Path) -> None:
    writer = McapWriter(RecordFile.create(tmp_path / "a.mcap"))
    channels = [writer.add_channel(f"/{number}", "std_msgs/msg/String", "string data") for number in range(CHANNELS)]

    def record(chunks: int) -> None:
        for _ in range(chunks):
            for channel in channels:
                writer.write(channel, bytes(8), START_NS, START_NS)
            writer.flush()

    def taken() -> int:
        gc.collect()
        mine = tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(True, "*/edgefusion/recording/*")])
        return sum(trace.size for trace in mine.traces)

    tracemalloc.start()
    record(20)
    before = taken()
    record(100)
    after = taken()
    tracemalloc.stop()
    writer.close()
    assert after - before < 100 * CHUNK_BYTES
