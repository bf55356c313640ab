# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""report.json of a drive: plain values, units in their names."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np

from edgefusion.sim.built_world import BuiltWorld
from edgefusion.tools.drive import Drive
from edgefusion.tools.drive_tally import DriveTally, sighting_row
from edgefusion.tools.report_folder import Pictured
from edgefusion.types import UNKNOWN

VERSION = 1


def report_of(world: BuiltWorld, drive: Drive, tally: DriveTally, pictured: Sequence[Pictured]) -> dict[str, Any]:
    """What was found, beside what was there; sightings with a name come first."""
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
        "drive": _drive(world, drive),
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


def _drive(world: BuiltWorld, drive: Drive) -> dict[str, float | None]:
    """clearance_m: None in a world without anything."""
    clearance_m = min(moment.clearance_m for moment in drive.trail)
    end, goal = drive.trail[-1], world.world.goal
    off, slipped = end.pose.relative_to(goal), end.pose.relative_to(end.believed)
    steps = np.diff([(moment.pose.x_m, moment.pose.y_m) for moment in drive.trail], axis=0)
    return {
        "duration_s": end.stamp_ns / 1e9,
        "way_m": float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        "goal_error_m": math.hypot(off.x_m, off.y_m),
        "goal_error_deg": abs(math.degrees(off.theta)),
        "odometry_error_m": math.hypot(slipped.x_m, slipped.y_m),
        "clearance_m": clearance_m if math.isfinite(clearance_m) else None,
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
