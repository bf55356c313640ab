# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a drive found, beside what was there: by object, by sighting, by stage of the detector."""

from __future__ import annotations

import dataclasses
from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np

from edgefusion.perception.calibration import Calibration
from edgefusion.perception.detector import StageTimes
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.truth import ObjectTruth
from edgefusion.sim.world import Thing
from edgefusion.tools.geometry import iou
from edgefusion.tools.measure import Seen, compare, owner_of
from edgefusion.tools.sightings import CONFIRMED_FRAMES, Sighting, Sightings
from edgefusion.tools.vision import Look
from edgefusion.types import Detection

BUILDING_NAME = "wall"


@dataclass(frozen=True)
class FirstSighting:
    """A sighting in the moment in which it was confirmed: the look, its detection there, and the object that most of
    the detection's beams met, None for a wall. truth: of that object in that look, None for what was not in it."""

    sighting: Sighting
    look: Look
    detection: Detection
    thing: Thing | None
    truth: ObjectTruth | None


class DriveTally:
    """Takes the looks of a drive as they come."""

    def __init__(self, world: BuiltWorld, calibration: Calibration) -> None:
        self._world, self._calibration = world, calibration
        self._clearances_m = [world.plan.clearance_m(index) for index in range(len(world.bodies))]
        self._sightings = Sightings()
        self._seen: dict[int, list[Seen]] = defaultdict(list)
        self._times: list[StageTimes] = []
        self.detections = 0

    def add(self, look: Look) -> list[FirstSighting]:
        """One more look; returns the sightings that it confirms."""
        name = self._world.world.name
        seen, _ = compare(look.shot, look.detections, self._calibration, self._clearances_m, name, look.number)
        for truth, each in zip(look.shot.truth, seen):
            self._seen[truth.index].append(each)
        self._times.append(look.times)
        self.detections += len(look.detections)
        confirmed = self._sightings.add(look.number, look.believed, look.detections)
        return [self._first(sighting, look) for sighting in confirmed]

    @property
    def frames(self) -> int:
        """How many looks there were."""
        return len(self._times)

    def objects(self) -> list[dict[str, Any]]:
        """A row for every object that both sensors saw, those of the aims first: in full view often enough."""
        rows = [_object_row(self._world.world.things[index].name, seen) for index, seen in self._seen.items()]
        return sorted(rows, key=lambda row: (not row["counts"], row["name"]))

    def stages_ms(self) -> dict[str, dict[str, float]]:
        """Median and 95th percentile of each stage, and of the whole frame."""
        names = [field.name for field in dataclasses.fields(StageTimes)]
        rows = np.array([[getattr(times, name) for name in names] for times in self._times]).reshape(-1, len(names))
        columns = {name[: -len("_ns")]: rows[:, i] for i, name in enumerate(names)}
        columns["whole frame"] = rows.sum(axis=1)
        return {name: _spread_ms(values) for name, values in columns.items() if len(values)}

    def distance_errors_m(self) -> Any:
        """[n, 3] of every detected object in full view: true distance, error, sigma."""
        found = [each for seen in self._seen.values() for each in seen if each.counts and each.found]
        rows = [(each.range_m, each.distance_error_m, each.sigma_m) for each in found]
        return np.array(rows, float).reshape(-1, 3)

    def _first(self, sighting: Sighting, look: Look) -> FirstSighting:
        detection = sighting.first
        assert detection is not None  # it was confirmed just now
        owner = owner_of(look.shot, detection)
        thing = self._world.world.things[owner] if owner >= 0 else None
        truth = next((each for each in look.shot.truth if each.index == owner), None)
        return FirstSighting(sighting, look, detection, thing, truth)


def _object_row(name: str, seen: Sequence[Seen]) -> dict[str, Any]:
    full = [each for each in seen if each.counts]
    found = [each for each in full if each.found]
    said = Counter(each.said for each in found).most_common()
    errors_mm = [1e3 * each.distance_error_m for each in found if each.distance_error_m is not None]
    return {
        "name": name,
        "label": seen[0].label,
        "counts": len(full) >= CONFIRMED_FRAMES,
        "frames_in_view": len(full),
        "frames_found": len(found),
        "found": len(found) >= CONFIRMED_FRAMES,
        "said": said[0][0] if said else None,
        "said_share": said[0][1] / len(found) if said else None,
        "named": bool(said) and said[0][0] == seen[0].label,
        "nearest_m": min(each.range_m for each in seen),
        "farthest_m": max(each.range_m for each in seen),
        "distance_error_mm_median": median_of(np.abs(errors_mm)),
        "iou_median": median_of([each.iou for each in found]),
    }


def sighting_row(first: FirstSighting) -> dict[str, Any]:
    """A sighting as plain values: what was said and measured when it was confirmed, beside the truth."""
    detection, truth, sighting, thing = first.detection, first.truth, first.sighting, first.thing
    return {
        "label": sighting.label,
        "true_label": None if thing is None else thing.kind.label,
        "object": BUILDING_NAME if thing is None else thing.name,
        "stamp_s": first.look.shot.frame.stamp_ns / 1e9,
        "frame": first.look.number,
        "frames": sighting.count,
        "place_m": list(sighting.place_m),
        "distance_m": detection.distance_m,
        "distance_sigma_m": detection.distance_sigma_m,
        "true_distance_m": None if truth is None else truth.range_m,
        "iou": None if truth is None else iou(detection.box, truth.box),
        "score": detection.score,
    }


def _spread_ms(values_ns: Any) -> dict[str, float]:
    median, p95 = np.percentile(values_ns, (50, 95)) / 1e6
    return {"median": float(median), "p95": float(p95)}


def median_of(values: Any) -> float | None:
    """None of nothing."""
    return float(np.median(np.asarray(values, float))) if len(values) else None
