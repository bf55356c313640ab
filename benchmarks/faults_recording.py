# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults while `edgefusion record` records a real bus: Y1, a disk that fills, and Y2, SIGKILL at any moment."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Callable, Iterator, List, NamedTuple

from benchmarks.fault_row import FaultRow
from benchmarks.faults_bus_rig import BusRig, wait_for

from edgefusion.bus.publisher import Publisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import IMAGE, MISSION
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
    """lost_s: how much older the newest message in the mended file is than the last one that was told."""

    lost_s: float
    replays: bool


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """tick: called after every run."""
    killed = [_killed(seed, tick) for seed in range(seeds)]
    whole = sum(run.replays for run in killed)
    return [
        *_full_disk(tick),
        FaultRow(
            "Y2",
            "SIGKILL while recording: lost",
            "at most 1 s, and all replay",
            1.0,
            [run.lost_s for run in killed],
            f"{whole} of {seeds} mended and read to the end",
            failed=whole < seeds,
        ),
    ]


def _killed(seed: int, tick: Callable[[], object]) -> Killed:
    with BusRig() as rig, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        with _recording(rig, path) as process:
            robot = Robot(rig)
            wait_for(robot.is_heard)
            until_s = time.monotonic() + random.Random(seed).uniform(*KILLED_WITHIN_S)
            robot.tell_until(lambda: time.monotonic() > until_s)
            process.kill()
            process.wait()
        found = recover(path)
        bag = McapBag(path)
        told_ns = [int(decode(String, message.data).data) for message in bag.read({"/mission"})]
        images = sum(1 for _ in bag.read({"/image/compressed"}))
        tick()
        return Killed((robot.newest_ns - told_ns[-1]) / 1e9, found.messages == len(told_ns) + images)


def _full_disk(tick: Callable[[], object]) -> List[FaultRow]:
    """The disk of the temporary folder, as full as the reserve makes it."""
    with BusRig() as rig, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        reserve_mb = _free_bytes(folder) // 1_000_000 - ROOM_MB
        with _recording(rig, path, "--reserve", str(reserve_mb)) as process:
            robot = Robot(rig)
            wait_for(robot.is_heard)
            robot.tell_until(lambda: process.poll() is not None)
            _, said = process.communicate()
        free_mb = _free_bytes(folder) / 1e6
        events = [line for line in said.splitlines() if "the recording ends here" in line]
        whole, code = recover(path), process.returncode
        tick()
        well = whole.was_whole and whole.messages > 0 and code == 1 and len(events) == len(said.splitlines()) == 1
        remark = (
            f"{whole.messages} messages in a whole file, {len(events)} event, {free_mb - reserve_mb:.1f} MB more free"
        )
        return [
            FaultRow("Y1", "disk full to the reserve while recording", "a whole file, one event, the reserve kept",
                     float("inf"), remark=remark, failed=not well or free_mb < reserve_mb),
            FaultRow("Y1", "the same: the robot's longest put", "5 ms", 0.005, [robot.longest_s]),
        ]  # fmt: skip


@contextmanager
def _recording(rig: BusRig, path: Path, *more: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "edgefusion.cli", "record", str(path), "--connect", rig.tcp, *more]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def _free_bytes(folder: str) -> int:
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize
