# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The objects of interest that are known: sightings become objects with a place, and each is visited once."""

from __future__ import annotations

import math
from bisect import insort
from dataclasses import dataclass, field
from typing import List, Tuple

from edgefusion.config import MissionConfig
from edgefusion.types import Detection

Point = Tuple[float, float]
"""(x, y) in `odom` [m]."""

MEMORY = 20
"""A place is the mean of about so many sightings, the newest: odometry drifts, and the place with it."""


def is_of_interest(detection: Detection, settings: MissionConfig) -> bool:
    """Whether an object is one to inspect: by its label or group, sure enough, near enough."""
    named = detection.label in settings.interest or detection.group in settings.interest
    return named and detection.score >= settings.min_score and detection.distance_m <= settings.max_distance_m


def kind_of(detection: Detection) -> str:
    """What an object is taken for: of a car, the label changes with the side that it is seen from, the group stays."""
    return detection.group or detection.label


@dataclass(eq=False)
class KnownObject:
    """Something that was sighted in one place, `place_m`. best: its sighting of the highest score.

    stamps_ns: of the frames that it was sighted in, rising, until they confirmed it. due: to be inspected as soon as
    the robot can; visited: an inspection began.
    """

    kind: str
    place_m: Point
    best: Detection
    stamps_ns: List[int] = field(default_factory=list)
    count: int = 0
    confirmed: bool = False
    due: bool = False
    visited: bool = False

    def apart_m(self, point: Point) -> float:
        return math.hypot(point[0] - self.place_m[0], point[1] - self.place_m[1])

    def sight(self, detection: Detection, point: Point) -> None:
        """One more sighting: moves the place towards it."""
        self.count = min(self.count + 1, MEMORY)
        self._move(point, 1 / self.count)
        self._better(detection)
        if detection.stamp_ns not in self.stamps_ns:
            insort(self.stamps_ns, detection.stamp_ns)

    def confirm(self, frames: int, window_ns: int) -> None:
        """Confirmed by so many frames that are all within the window, in whatever order they arrived."""
        ends = zip(self.stamps_ns, self.stamps_ns[frames - 1 :])
        if self.confirmed or any(last - first <= window_ns for first, last in ends):
            self.confirmed = True
            self.stamps_ns.clear()

    def absorb(self, other: KnownObject) -> None:
        """Takes over what is known of an object that turns out to be this one."""
        self._move(other.place_m, other.count / (self.count + other.count))
        self._better(other.best)
        self.count = min(self.count + other.count, MEMORY)
        self.stamps_ns = sorted({*self.stamps_ns, *other.stamps_ns})
        self.confirmed |= other.confirmed
        self.due |= other.due
        self.visited |= other.visited

    def _move(self, towards: Point, share: float) -> None:
        x_m, y_m = self.place_m
        self.place_m = (x_m + share * (towards[0] - x_m), y_m + share * (towards[1] - y_m))

    def _better(self, detection: Detection) -> None:
        if detection.score > self.best.score:
            self.best = detection


class KnownObjects:
    """All that is known. No two objects of one kind are within `same_place_m` of each other: they would be one."""

    def __init__(self, settings: MissionConfig) -> None:
        self._settings = settings
        self._window_ns = round(settings.confirm_s * 1e9)
        self._all: list[KnownObject] = []

    def __len__(self) -> int:
        return len(self._all)

    def add(self, detection: Detection, point: Point) -> KnownObject:
        """The object that a detection at a point is a sighting of, known before or not."""
        found = self.at(kind_of(detection), point)
        if found is None:
            found = KnownObject(kind_of(detection), point, detection)
            self._all.append(found)
        found.sight(detection, point)
        found = self._merged(found)
        found.confirm(self._settings.confirm_frames, self._window_ns)
        return found

    def at(self, kind: str, point: Point, but: KnownObject | None = None) -> KnownObject | None:
        """The object of a kind that is nearest to a point, if it is near enough to be the one there."""
        near = (
            each
            for each in self._all
            if each.kind == kind and each is not but and each.apart_m(point) <= self._settings.same_place_m
        )
        return min(near, key=lambda each: each.apart_m(point), default=None)

    def next_due(self, here: Point) -> KnownObject | None:
        """The nearest object that is due and not yet visited."""
        due = (each for each in self._all if each.due and not each.visited)
        return min(due, key=lambda each: each.apart_m(here), default=None)

    def none_due(self) -> None:
        """What was due is so no longer, until it is sighted again."""
        for each in self._all:
            each.due = False

    def not_visited(self, kind: str, point: Point) -> None:
        """The visit of the object there came to nothing."""
        found = self.at(kind, point)
        if found is not None:
            found.visited = False

    def forget_unconfirmed(self, before_ns: int) -> None:
        """Frames older than this can no longer confirm anything; what has no newer ones was a mistake."""
        for each in self._all:
            each.stamps_ns = [stamp_ns for stamp_ns in each.stamps_ns if stamp_ns >= before_ns]
        self._all = [each for each in self._all if each.confirmed or each.stamps_ns]

    def _merged(self, found: KnownObject) -> KnownObject:
        """Sightings move places: what gets near enough to be one object becomes the one that was known first."""
        other = self.at(found.kind, found.place_m, but=found)
        while other is not None:
            first, second = sorted((found, other), key=self._all.index)
            first.absorb(second)
            self._all.remove(second)
            found, other = first, self.at(first.kind, first.place_m, but=first)
        return found
