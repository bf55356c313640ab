# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What came is on the disk soon, and the end of the disk is the end of the recording, not of what was recorded."""

from __future__ import annotations

import os
import signal
import threading
from io import BytesIO
from pathlib import Path
from typing import Iterator

import pytest

from edgefusion.bus.subscriber import Received
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import MISSION, ODOM, Topic
from edgefusion.clock import SimClock
from edgefusion.messages.cdr import encode
from edgefusion.messages.nav_msgs import Odometry
from edgefusion.messages.std_msgs import String
from edgefusion.recording.mcap_bag import McapBag
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile
from edgefusion.recording.recorder import SYNC_NS, Recorder
from edgefusion.recording.recover import recover
from edgefusion.tools.record_loop import record
from mcap_scenes import START_NS, FullDisk, read_by_mcap

MS = 1_000_000


class SyncedFile(RecordFile):
    """Knows what was in the file when it was last on the disk itself."""

    on_disk = 0

    def sync(self) -> None:
        super().sync()
        self.on_disk = self.tell()


class ScriptedTap:
    """Gives what is scripted for each turn, and ends the program at the end of the script."""

    def __init__(self, topic: Topic, turns: list[list[Received]], dropped: int = 0) -> None:
        self.topic, self.dropped = topic, dropped
        self._turns = iter(turns)

    def take(self) -> list[Received]:
        turn = next(self._turns, None)
        if turn is None:
            os.kill(os.getpid(), signal.SIGTERM)
        return turn or []


def received(text: str, at_ns: int, attachment: bytes | None = None) -> Received:
    return Received("robot/mission", encode(String(text)), attachment, "", at_ns)


def texts(path: Path) -> Iterator[str]:
    return (message.data[8:-1].decode() for message in McapBag(path).read())


def test_a_power_cut_at_any_moment_costs_less_than_a_second(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    file = SyncedFile(os.open(path, os.O_RDWR | os.O_CREAT))
    recorder = Recorder(McapWriter(file), 0)
    for now_ns in range(0, 5000 * MS, 20 * MS):
        recorder.add("/mission", String, encode(String("x")), START_NS + now_ns)
        recorder.sync_if_due(now_ns)
        if now_ns < SYNC_NS:
            continue
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(path.read_bytes()[: file.on_disk])
        recover(cut)
        newest_ns = read_by_mcap(BytesIO(cut.read_bytes()))[-1].log_ns - START_NS
        assert now_ns - newest_ns <= SYNC_NS < 1000 * MS
    recorder.close()


def test_messages_are_recorded_in_the_order_in_which_they_came_with_utc_and_their_senders_numbers(
    tmp_path: Path,
) -> None:
    path, tagger = tmp_path / "a.mcap", Tagger("base")
    missions = [received("a", 30, tagger.sample("x", 0)), received("b", 50, b"no tag")]
    odom = [Received("robot/odom", encode(Odometry()), tagger.sample("x", 0), "", 40)]
    taps = [ScriptedTap(MISSION, [missions, []]), ScriptedTap(ODOM, [odom, []])]
    recorder = Recorder(McapWriter(RecordFile.create(path)), 0)
    assert record(path, recorder, taps, SimClock(), offset_ns=START_NS) == 0
    assert [(m.topic, m.type_name, m.log_ns - START_NS) for m in McapBag(path).read()] == [
        ("/mission", "std_msgs/msg/String", 30), ("/odom", "nav_msgs/msg/Odometry", 40),
        ("/mission", "std_msgs/msg/String", 50),
    ]  # fmt: skip


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_signal_ends_the_recording_well(tmp_path: Path, number: signal.Signals) -> None:
    path = tmp_path / "a.mcap"
    tap = ScriptedTap(MISSION, [[received("a", 1)]] + [[]] * 1000)
    threading.Timer(0.2, os.kill, (os.getpid(), number)).start()
    assert record(path, Recorder(McapWriter(RecordFile.create(path)), 0), [tap], SimClock()) == 0
    assert list(texts(path)) == ["a"]
    assert recover(path).was_whole


def test_a_full_disk_ends_the_recording_with_one_event_and_a_file_that_is_well(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    """FAULTS Y1."""
    path, clock = tmp_path / "a.mcap", SimClock()
    file = RecordFile(os.open(path, os.O_RDWR | os.O_CREAT), write=FullDisk(20_000))

    def turn(i: int) -> list[Received]:
        clock.advance(SYNC_NS)
        return [received(f"{i:04d}" + "x" * 1000, i)]

    tap = ScriptedTap(MISSION, [])
    tap._turns = map(turn, range(1000))
    assert record(path, Recorder(McapWriter(file), 0), [tap], clock) == 1
    (event,) = caplog.records
    assert event.getMessage() == f"{path}: the recording ends here: No space left on device"
    kept = [int(text[:4]) for text in texts(path)]
    assert kept == list(range(len(kept))) and len(kept) > 10
    assert f"{path}: {len(kept)} messages of 1 topics" in capsys.readouterr().out
    assert recover(path).was_whole


def test_what_a_slow_disk_made_go_lost_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.mcap"
    taps = [ScriptedTap(MISSION, [[received("a", 1)]], dropped=7), ScriptedTap(ODOM, [])]
    record(path, Recorder(McapWriter(RecordFile.create(path)), 0), taps, SimClock())
    assert "1 messages of 1 topics, 0.0 MB; dropped, since the disk is slow: mission 7" in capsys.readouterr().out
