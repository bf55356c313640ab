# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From detections of single frames to things that stand somewhere: a sighting is confirmed by several frames."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from statistics import median
from typing import List, Sequence

from edgefusion.sim.world import Point
from edgefusion.types import Detection, Pose2D

SAME_PLACE_M = 0.6
"""Detections of one label that are no farther apart are of one thing."""

CONFIRMED_FRAMES = 3


@dataclass
class Sighting:
    """Detections of one label at one place. points: of each, where its nearest surface was [m], in the frame of the
    poses; frames: of each, the frame's number, rising, some more than once; first: the detection that confirmed it."""

    label: str
    points: List[Point] = field(default_factory=list)
    frames: List[int] = field(default_factory=list)
    detections: List[Detection] = field(default_factory=list)
    first: Detection | None = None

    @property
    def count(self) -> int:
        """In how many frames it was seen."""
        return len(set(self.frames))

    @property
    def place_m(self) -> Point:
        """The middle of its points, by median."""
        return median(x for x, _ in self.points), median(y for _, y in self.points)

    def apart_m(self, point: Point) -> float:
        """From a point to the nearest at which it was seen: the nearest surface wanders as the robot drives by."""
        return min(math.hypot(point[0] - x, point[1] - y) for x, y in self.points)

    def add(self, frame: int, detection: Detection, point: Point) -> bool:
        """One more detection; says whether it is the one that confirms."""
        self.points.append(point)
        self.frames.append(frame)
        self.detections.append(detection)
        if self.first is not None or self.count < CONFIRMED_FRAMES:
            return False
        self.first = detection
        return True


class Sightings:
    """Gathers the detections of a drive, frame after frame."""

    def __init__(self) -> None:
        self._all: list[Sighting] = []

    @property
    def confirmed(self) -> list[Sighting]:
        """Those seen in enough frames, in the order in which they began."""
        return [sighting for sighting in self._all if sighting.first is not None]

    def add(self, frame: int, pose: Pose2D, detections: Sequence[Detection]) -> list[Sighting]:
        """The detections of a frame, seen from the base's pose at their stamp; returns what they confirm."""
        confirmed = []
        for detection in detections:
            point = pose.compose(Pose2D(*detection.position_m))
            sighting = self._at(detection.label, (point.x_m, point.y_m))
            if sighting.add(frame, detection, (point.x_m, point.y_m)):
                confirmed.append(sighting)
        return confirmed

    def _at(self, label: str, point: Point) -> Sighting:
        """The sighting of this label that is nearest to a point, or a new one."""
        same = (each for each in self._all if each.label == label and each.apart_m(point) <= SAME_PLACE_M)
        found = min(same, key=lambda each: each.apart_m(point), default=None)
        if found is None:
            found = Sighting(label)
            self._all.append(found)
        return found
