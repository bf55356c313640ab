# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A laptop's program beside a robot: `python -m benchmarks.end_to_end_laptop ENDPOINT FOLDER X Y THETA LABEL`.

It says on standard output how it gets on, in lines of JSON, waits for a line before it gives the goal, and leaves in
FOLDER what it got: laptop.json, and the pictures of inspections. All of it goes through the doors that users have.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from pathlib import Path
from typing import Any, Dict, List, Mapping, Tuple

import msgspec
from benchmarks.joining import joined

from edgefusion.bus import topics
from edgefusion.bus.client import Robot
from edgefusion.bus.session import UnreachableError
from edgefusion.clock import system_clock
from edgefusion.errors import RefusedError
from edgefusion.messages.mission_report import InspectionReport, MissionReport
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.std_msgs import String
from edgefusion.types import HealthState

JOINING_S = 60.0
AFTER_S = 0.5
"""What is said last of a drive has a way to go."""


class Notes:
    """frames: of each, its stamp, when its objects were known here, and their labels. figures: what components said of
    themselves, again and again."""

    def __init__(self) -> None:
        self.frames: List[Tuple[int, int, List[str]]] = []
        self.pictures: List[bytes] = []
        self.inspections: List[Dict[str, Any]] = []
        self.figures: List[Tuple[int, Dict[str, Mapping[str, str]]]] = []

    def watch(self, robot: Robot) -> None:
        """From now on, in threads."""
        for watcher in (self._watch_frames, self._watch_pictures, self._watch_inspections):
            threading.Thread(target=watcher, args=(robot,), daemon=True).start()

    def ask(self, robot: Robot) -> bool:
        """How the components are now; whether all are well, vision among them."""
        reports = robot.status.healths
        self.figures.append((system_clock(), {report.health.component: report.figures for report in reports}))
        healths = {report.health.component: report.health.state for report in reports}
        return "detector" in healths and set(healths.values()) == {HealthState.OK}

    def _watch_frames(self, robot: Robot) -> None:
        for frame in robot.frames():
            self.frames.append((frame.stamp_ns, system_clock(), [each.label for each in frame.detections]))

    def _watch_pictures(self, robot: Robot) -> None:
        self.pictures.extend(robot.read(topics.INSPECTION, _jpeg))

    def _watch_inspections(self, robot: Robot) -> None:
        self.inspections.extend(robot.read(topics.INSPECTION_META, _report))


def _jpeg(message: CompressedImage) -> bytes:
    return bytes(message.data)


def _report(message: String) -> Dict[str, Any]:
    return dict(msgspec.to_builtins(msgspec.json.decode(message.data, type=InspectionReport)))


def main(argv: List[str]) -> None:
    endpoint, folder, x_m, y_m, theta, label = argv
    notes = Notes()
    with joined(endpoint, JOINING_S) as robot:
        _say("joined")
        notes.watch(robot)
        _wait(lambda: notes.frames)
        _say("seen", ns=notes.frames[0][1])
        _wait(lambda: notes.ask(robot))
        _say("well")
        sys.stdin.readline()
        begun_ns = system_clock()
        last = _drive(robot, notes, (float(x_m), float(y_m), float(theta)), label)
        time.sleep(AFTER_S)
        _leave(Path(folder), notes, begun_ns, last)
    _say("ended", state=last.state, reason=last.reason)


def _drive(robot: Robot, notes: Notes, goal: Tuple[float, float, float], label: str) -> MissionReport:
    inspect = [label] if label else []
    for report in robot.progress(_accepted(robot, goal, inspect)):
        notes.ask(robot)
        _say("reports", state=report.state, way_left_m=report.way_left_m)
        if report.state == "stopped":  # nobody is here who would resume it
            break
    return report


def _accepted(robot: Robot, goal: Tuple[float, float, float], inspect: List[str]) -> Any:
    """A base that is just well may need a moment more."""
    end_s = time.monotonic() + JOINING_S
    while True:
        try:
            return robot.goto(*goal, inspect=inspect)
        except RefusedError:
            if time.monotonic() > end_s:
                raise
            time.sleep(0.1)


def _leave(folder: Path, notes: Notes, begun_ns: int, last: MissionReport) -> None:
    for number, jpeg in enumerate(notes.pictures):
        (folder / f"delivered-{number}.jpg").write_bytes(jpeg)
    record = {
        "begun_ns": begun_ns,
        "state": last.state,
        "reason": last.reason,
        "pose": last.pose,
        "frames": notes.frames,
        "inspections": notes.inspections,
        "figures": notes.figures,
    }
    (folder / "laptop.json").write_text(json.dumps(record), encoding="utf-8")


def _wait(holds: Any) -> None:
    end_s = time.monotonic() + JOINING_S
    while not holds():
        if time.monotonic() > end_s:
            raise UnreachableError(f"expected the robot to be well within {JOINING_S:g} s")
        time.sleep(0.02)


def _say(event: str, **what: Any) -> None:
    print(json.dumps({"event": event, **what}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
