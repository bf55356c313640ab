# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One drive, end to end: simulated devices in this process, the robot's processes, and a laptop's."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Tuple

from benchmarks.end_to_end_robot import RobotProcess, RobotSetup, free_endpoint, write_config
from benchmarks.end_to_end_world import LiveRun
from benchmarks.process_memory import Memory, MemoryWatch, memory

from edgefusion.errors import RefusedError
from edgefusion.sim.live_devices import LiveSetup

READY_S, DRIVE_S, REST_S = 90.0, 300.0, 3.0


class Laptop:
    """A process; said: what it has said, by event the last."""

    def __init__(self, endpoint: str, folder: Path, goal: Tuple[float, float, float], label: str) -> None:
        arguments = [endpoint, str(folder), *map(repr, goal), label]
        command = [sys.executable, "-m", "benchmarks.end_to_end_laptop", *arguments]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.said: Dict[str, Dict[str, Any]] = {}
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    @property
    def ended(self) -> bool:
        return not self._thread.is_alive()

    def go(self) -> None:
        """It gives the goal."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()
        self._thread.join()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            said = json.loads(line)
            self.said[said["event"]] = said


@dataclass(frozen=True)
class EndToEnd:
    """What came of a drive. laptop: laptop.json, empty where it did not come to it; trouble: why not.

    seen_s: from the start of `edgefusion run` to the first frame whose objects the laptop knew, 0 where there was none;
    ended_s: what the robot's processes took to end.
    """

    folder: Path
    live: LiveRun
    laptop: Mapping[str, Any]
    trouble: str
    seen_s: float
    ended_s: float
    at_rest: Mapping[str, Memory]
    at_work: Mapping[str, Memory]


def run(world: LiveSetup, setup: RobotSetup, label: str, folder: Path, rest_s: float = REST_S) -> EndToEnd:
    """Drives to the world's goal, and inspects what has this label. folder: for the robot's files, its log and what the
    laptop got. Raises RefusedError where pictures cannot be rendered."""
    folder.mkdir(parents=True, exist_ok=True)
    goal = world.world.goal.relative_to(world.world.start)
    endpoint = free_endpoint()
    with ExitStack() as stack:
        live = LiveRun(world)
        stack.callback(live.close)
        _wait_for_camera(live)
        config = write_config(folder, live.devices, setup, endpoint)
        laptop = Laptop(endpoint, folder, (goal.x_m, goal.y_m, goal.theta), label)
        stack.callback(laptop.close)
        robot = RobotProcess(config, folder / "robot.log")
        try:
            trouble, at_rest, at_work = _drive(live, laptop, robot, rest_s)
        finally:
            ended_s = _end(live, robot)
        seen = laptop.said.get("seen")
        came = {} if trouble else json.loads((folder / "laptop.json").read_text(encoding="utf-8"))
        seen_s = 0.0 if seen is None else (seen["ns"] - robot.started_ns) / 1e9
        return EndToEnd(folder, live, came, trouble, seen_s, ended_s, at_rest, at_work)


def _drive(
    live: LiveRun, laptop: Laptop, robot: RobotProcess, rest_s: float
) -> Tuple[str, Dict[str, Memory], Dict[str, Memory]]:
    """Why it came to nothing, empty where the drive has ended by itself; and the memory at rest and at work."""
    live.until(lambda: "well" in laptop.said or laptop.ended or not robot.lives, READY_S)
    if "well" not in laptop.said:
        return "the robot was not well in time", {}, {}
    live.go_on(rest_s)
    at_rest, watch = memory(robot.pid), MemoryWatch(robot.pid)
    laptop.go()
    live.until(lambda: laptop.ended or not robot.lives, DRIVE_S)
    trouble = "" if "ended" in laptop.said else "the drive did not end in time"
    return trouble, at_rest, watch.end()


def _end(live: LiveRun, robot: RobotProcess) -> float:
    """While its devices live on."""
    took_s: List[float] = []
    thread = threading.Thread(target=lambda: took_s.append(robot.end()))
    thread.start()
    live.until(lambda: not thread.is_alive(), READY_S)
    return took_s[0]


def _wait_for_camera(live: LiveRun) -> None:
    camera = live.devices.camera
    assert camera is not None
    live.until(lambda: camera.ready or camera.fault, READY_S)
    if not camera.ready:
        raise RefusedError(f"the simulated camera: {camera.fault or 'it was not ready in time'}")
