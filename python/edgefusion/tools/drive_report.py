# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""report.json of a drive: plain values, units in their names; places and poses in the world, angles in degrees."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np

from edgefusion.navigation.mission_step import MissionState
from edgefusion.navigation.safety import Action
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.tools.drive import Drive
from edgefusion.tools.drive_log import DriveLog
from edgefusion.tools.drive_tally import DriveTally, sighting_row
from edgefusion.tools.report_folder import Kept, Pictured
from edgefusion.types import UNKNOWN, Pose2D

VERSION = 2


def report_of(
    world: BuiltWorld, drive: Drive, tally: DriveTally, pictured: Sequence[Pictured], kept: Sequence[Kept]
) -> dict[str, Any]:
    """How the drive went, what was inspected, and what was found beside what was there; sightings with a name come
    first."""
    objects = tally.objects()
    counted = [row for row in objects if row["counts"]]
    found = [row for row in counted if row["found"]]
    rows = [{**sighting_row(first), "image": image, "scan": scan} for first, image, scan in pictured]
    return {
        "version": VERSION,
        "world": world.world.name,
        "frames": tally.frames,
        "detections": tally.detections,
        "pairing": drive.pairing,
        "drive": drive_figures(drive, world.world.goal),
        "mission": {
            "inspections": [_inspection(each, drive, world.world.start) for each in kept],
            "events": [
                {"stamp_s": stamp_ns / 1e9, "what": what, "pose": _pose(believed)}
                for stamp_ns, what, believed in drive.log.events
            ],
        },
        "gate": _gate(drive.log),
        "objects": {
            "in_view": len(counted),
            "found": len(found),
            "named": sum(row["named"] for row in found),
        },
        "distance_error_mm": _distances(tally.distance_errors_m()),
        "stages_ms": tally.stages_ms(),
        "sightings": sorted(rows, key=lambda row: (row["label"] == UNKNOWN, row["stamp_s"])),
        "by_object": objects,
    }


def drive_figures(drive: Drive, goal: Pose2D) -> dict[str, Any]:
    """odometry_error: of the end pose by odometry, which is all that the robot knows; true_error: of the end pose.
    clearance_m: of the hull, in the laser's plane; None in a world without anything."""
    trail = drive.log.trail
    end = trail[-1]
    steps = np.diff([(moment.pose.x_m, moment.pose.y_m) for moment in trail], axis=0)
    return {
        "outcome": drive.state.value,
        "reason": drive.reason,
        "arrived": drive.state is MissionState.ARRIVED,
        "goal": _pose(goal),
        "duration_s": end.stamp_ns / 1e9,
        "way_m": float(np.hypot(*steps.reshape(-1, 2).T).sum()),
        **_error("odometry_error", end.believed.relative_to(goal)),
        **_error("true_error", end.pose.relative_to(goal)),
        **_error("drift", end.pose.relative_to(end.believed)),
        "clearance_m": drive.clearance_m if math.isfinite(drive.clearance_m) else None,
    }


def _error(name: str, off: Pose2D) -> dict[str, float]:
    return {f"{name}_m": math.hypot(off.x_m, off.y_m), f"{name}_deg": abs(math.degrees(off.theta))}


def _pose(pose: Pose2D) -> list[float]:
    return [pose.x_m, pose.y_m, math.degrees(pose.theta)]


def _inspection(kept: Kept, drive: Drive, start: Pose2D) -> dict[str, Any]:
    """object: what the picture's detection really is, None for a wall and where nothing was detected in it."""
    result = kept.result
    place = start.compose(Pose2D(*result.place_m))
    return {
        "id": result.id,
        "label": result.label,
        "group": result.group,
        "object": drive.pictured.get(result.id),
        "place_m": [place.x_m, place.y_m],
        "pose": _pose(start.compose(result.pose)),
        "distance_m": result.detection.distance_m,
        "score": result.detection.score,
        "begun_s": result.begun_ns / 1e9,
        "stood_s": None if result.stood_ns is None else result.stood_ns / 1e9,
        "ended_s": result.ended_ns / 1e9,
        "picture": kept.picture,
        "json": kept.json,
        "reason": result.reason,
        "note": result.note,
    }


def _gate(log: DriveLog) -> dict[str, Any]:
    """decisions: how many commands it let pass as they were, slowed down, or made zero."""
    return {
        "decisions": {action.name.lower(): log.decisions[action] for action in Action},
        "spells": [
            {
                "action": spell.action.name.lower(),
                "reason": spell.reason,
                "from_s": spell.from_ns / 1e9,
                "until_s": spell.until_ns / 1e9,
            }
            for spell in log.spells
        ],
    }


def _distances(errors_m: Any) -> dict[str, float | None]:
    """Of [n, 3]: true distance, error, sigma."""
    if not len(errors_m):
        return {"median": None, "p95": None, "bias": None, "within_2_sigma": None}
    error, sigma = errors_m[:, 1], errors_m[:, 2]
    return {
        "median": 1e3 * float(np.median(np.abs(error))),
        "p95": 1e3 * float(np.percentile(np.abs(error), 95)),
        "bias": 1e3 * float(np.mean(error)),
        "within_2_sigma": float(np.mean(np.abs(error) <= 2 * sigma)),
    }
