# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults while `edgefusion record` records a real bus: Y1, a disk that fills, and Y2, SIGKILL at any moment."""

from __future__ import annotations

import math
import os
import random
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Callable, Iterator, List, NamedTuple, Optional

from benchmarks.fault_row import FaultRow
from benchmarks.faults_bus_rig import PATIENCE_S, BusRig, wait_for

from edgefusion.bus.publisher import Publisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import IMAGE, MISSION
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.std_msgs import String
from edgefusion.recording.mcap_bag import McapBag
from edgefusion.recording.recover import recover

PERIOD_S = 0.02
IMAGE_BYTES = 100_000
KILLED_WITHIN_S = (1.0, 3.0)
ROOM_MB = 5
"""Above the reserve when the recording begins."""


class Robot:
    """Tells the time and an image fifty times a second."""

    def __init__(self, rig: BusRig) -> None:
        session, tagger = rig.member(), Tagger()
        self._mission = Publisher(session, "robot", MISSION, tagger, "boot")
        self._image = Publisher(session, "robot", IMAGE, tagger, "boot")
        self._picture = CompressedImage(format="jpeg", data=os.urandom(IMAGE_BYTES))
        self.longest_s = 0.0
        self.newest_ns = 0

    def tell_until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            start_ns = time.monotonic_ns()
            self.newest_ns = start_ns
            self._mission.put(String(str(start_ns)), start_ns)
            self._image.put(self._picture, start_ns)
            self.longest_s = max(self.longest_s, (time.monotonic_ns() - start_ns) / 1e9)
            time.sleep(PERIOD_S)

    def is_heard(self) -> bool:
        return self._mission.wanted(0) and self._image.wanted(0)


class Killed(NamedTuple):
    """lost_s: how much older the newest message in the mended file is than the last one that was told; None where
    nothing is in it, or it cannot be mended."""

    lost_s: Optional[float]
    replays: bool


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """tick: called after every run."""
    killed = [_killed(seed, tick) for seed in range(seeds)]
    whole = sum(run.replays for run in killed)
    empty = sum(run.lost_s is None for run in killed)
    return [
        *_full_disk(tick),
        FaultRow(
            "Y2",
            "SIGKILL while recording: lost",
            "at most 1 s, and all replay",
            1.0,
            [run.lost_s for run in killed if run.lost_s is not None],
            f"{whole} of {seeds} mended and read to the end" + (f", nothing left of {empty}" if empty else ""),
            failed=whole < seeds,
        ),
    ]


def _killed(seed: int, tick: Callable[[], object]) -> Killed:
    with BusRig() as rig, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        with _recording(rig, path) as process:
            robot = Robot(rig)
            wait_for(lambda: robot.is_heard() and path.exists())  # it listens before it makes its file
            until_s = time.monotonic() + random.Random(seed).uniform(*KILLED_WITHIN_S)
            robot.tell_until(lambda: time.monotonic() > until_s)
            process.kill()
            process.wait()
        tick()
        return _left(path, robot.newest_ns)


def _left(path: Path, newest_ns: int) -> Killed:
    try:
        found = recover(path)
        bag = McapBag(path)
        told_ns = [int(decode(String, message.data).data) for message in bag.read({"/mission"})]
        images = sum(1 for _ in bag.read({"/image/compressed"}))
    except RefusedError:  # a file that cannot be mended is a row, not the end of all others
        return Killed(None, False)
    if not told_ns:
        return Killed(None, False)
    return Killed((newest_ns - told_ns[-1]) / 1e9, found.messages == len(told_ns) + images)


def _full_disk(tick: Callable[[], object]) -> List[FaultRow]:
    """A disk as full as the reserve makes it."""
    with BusRig() as rig, tempfile.TemporaryDirectory(dir=_quiet_folder()) as folder:
        path = Path(folder) / "drive.mcap"
        reserve_mb = _free_bytes(folder) // 1_000_000 - ROOM_MB
        with _recording(rig, path, "--reserve", str(reserve_mb)) as process:
            robot = Robot(rig)
            wait_for(lambda: process.poll() is not None or (robot.is_heard() and path.exists()))
            end_s = time.monotonic() + PATIENCE_S
            robot.tell_until(lambda: process.poll() is not None or time.monotonic() > end_s)
            process.kill()
            _, said = process.communicate()
        free_mb, code = _free_bytes(folder) / 1e6, process.returncode
        tick()
        return [
            _full_disk_row(path, said.splitlines(), code, free_mb - reserve_mb),
            FaultRow("Y1", "the same: the robot's longest put", "5 ms", 0.005, [robot.longest_s]),
        ]


def _full_disk_row(path: Path, said: List[str], code: int, left_mb: float) -> FaultRow:
    """left_mb: what is free beside the reserve. Others write to the disk, too: what they take is not the recording's,
    which had no more than its room either way."""
    row = FaultRow(
        "Y1", "disk full to the reserve while recording", "a whole file, one event, the reserve kept", math.inf
    )
    try:
        whole, size_mb = recover(path), path.stat().st_size / 1e6
    except (RefusedError, OSError):
        return replace(row, remark=f"no recording: exit code {code}, {' '.join(said)[:200]}", failed=True)
    events = sum("the recording ends here" in line for line in said)
    kept = left_mb >= 0 or size_mb <= ROOM_MB
    well = whole.was_whole and whole.messages > 0 and code == 1 and events == len(said) == 1 and kept
    remark = f"{whole.messages} messages in a whole file, {events} event, {left_mb:.1f} MB more free"
    return replace(row, remark=remark, failed=not well)


@contextmanager
def _recording(rig: BusRig, path: Path, *more: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "edgefusion.cli", "record", str(path), "--connect", rig.tcp, *more]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def _quiet_folder() -> Optional[str]:
    """In memory, where few others write meanwhile; None, the usual one, where there is none with room."""
    memory = "/dev/shm"
    usable = os.access(memory, os.W_OK) and _free_bytes(memory) > 10 * ROOM_MB * 1_000_000
    return memory if usable else None


def _free_bytes(folder: str) -> int:
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize
