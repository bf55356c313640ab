# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is told of a robot that is watched over the bus: as data for programs, and in words for people."""

from __future__ import annotations

import math
from typing import Any, Iterator, NamedTuple

import msgspec

from edgefusion.bus.listener import Status
from edgefusion.messages.to_detections_detail import Detections
from edgefusion.messages.to_healths import Report
from edgefusion.tools.mission_words import mission_in_words, pose_in_words
from edgefusion.types import Detection

_NAME = 28
SILENT_S = 3.0
"""What is older is told with its age."""

_OF_DETECTION = (
    "label", "group", "score", "margin", "distance_m", "distance_sigma_m", "bearing", "position_m", "box",
)  # fmt: skip


class Seen(NamedTuple):
    """The newest frame: how long ago it came, and how many do in a second."""

    frame: Detections
    age_s: float
    rate_hz: float


class Watched(NamedTuple):
    """A robot's name, what it last said of itself, and what it saw; None before its first frame."""

    name: str
    status: Status
    seen: Seen | None

    @property
    def says_everything(self) -> bool:
        """Whether nothing is missing that each robot says."""
        return bool(self.status.mission and self.status.healths and self.seen)

    @property
    def says_something(self) -> bool:
        return bool(self.status.mission or self.status.healths or self.seen)


def facts(watched: Watched) -> dict[str, Any]:
    """Everything that is told, for JSON. Angles in radians; None for what the robot has not said."""
    status, battery = watched.status, watched.status.battery
    return {
        "robot": watched.name,
        "alive": sorted(status.alive),
        "mission": msgspec.to_builtins(status.mission),
        "mission_age_s": status.age_s,
        "battery": None if battery is None else {"voltage_v": battery.voltage_v, "charging": battery.charging},
        "components": [_component_facts(report) for report in status.healths],
        "seen": None if watched.seen is None else _seen_facts(watched.seen),
    }


def in_words(watched: Watched) -> list[str]:
    """A few lines, and one for each object and component."""
    status = watched.status
    alive = f"{', '.join(sorted(status.alive))} alive" if status.alive else "nothing of it is alive on this bus"
    return [
        f"robot    {watched.name}: {alive}",
        *_mission_lines(status),
        f"battery  {_battery(status)}",
        *_object_lines(watched.seen),
        *(f"{report.health.component:<8} {_state(report)}" for report in status.healths),
    ]


def _component_facts(report: Report) -> dict[str, Any]:
    component, state, reason = report.health.component, report.health.state.value, report.health.reason
    return {"name": component, "state": state, "reason": reason, "figures": report.figures}


def _seen_facts(seen: Seen) -> dict[str, Any]:
    detections = [{name: getattr(each, name) for name in _OF_DETECTION} for each in seen.frame.detections]
    return {
        "stamp_ns": seen.frame.stamp_ns,
        "age_s": seen.age_s,
        "frames_per_s": seen.rate_hz,
        "detections": detections,
    }


def _mission_lines(status: Status) -> Iterator[str]:
    if status.mission is None:
        yield "mission  nothing heard"
        return
    age_s = status.age_s or 0.0
    yield f"mission  {mission_in_words(status.mission)}" + (f"; told {age_s:.0f} s ago" if age_s > SILENT_S else "")
    yield f"pose     {pose_in_words(status.mission.pose)}"


def _battery(status: Status) -> str:
    if status.battery is None:
        return "nothing heard"
    return (
        f"{status.battery.voltage_v:.1f} V"
        + {True: ", charging", False: ", not charging", None: ""}[status.battery.charging]
    )


def _object_lines(seen: Seen | None) -> Iterator[str]:
    if seen is None:
        yield "objects  no frame yet"
        return
    detections = sorted(seen.frame.detections, key=lambda detection: detection.distance_m)
    silent = f"; it came {seen.age_s:.0f} s ago" if seen.age_s > SILENT_S else ""
    rate = f", {seen.rate_hz:.1f} frames/s" if seen.rate_hz or silent else ""  # of a single frame there is none
    yield f"objects  {len(detections)} in the newest frame{rate}{silent}"
    yield from map(_object_line, detections)


def _object_line(detection: Detection) -> str:
    name = f"{detection.label} ({detection.group})" if detection.group else detection.label
    name = name if len(name) <= _NAME else f"{name[: _NAME - 2]}.."
    distance = f"{detection.distance_m:5.2f} m +-{detection.distance_sigma_m:.2f}"
    side = "left" if detection.bearing >= 0 else "right"
    return (
        f"         {name:<{_NAME}} {distance} {abs(math.degrees(detection.bearing)):3.0f} deg {side:<5}"
        f" score {detection.score:.2f}"
    )


def _state(report: Report) -> str:
    health, figures = report.health, ", ".join(f"{name} {value}" for name, value in report.figures.items())
    reason = f": {health.reason}" if health.reason else ""
    return f"{health.state.value}{reason}" + (f" ({figures})" if figures else "")
