# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a drive's notes come to: the drive, how old a detection is when a laptop knows it, and where that time went."""

from __future__ import annotations

import math
from statistics import median
from typing import Any, Dict, List, Mapping, NamedTuple, Sequence

import numpy as np
import numpy.typing as npt
from benchmarks.end_to_end_run import EndToEnd

from edgefusion.types import Pose2D

STAGES = {
    "waits for its scan, and for the detector": "age when begun [ms]",
    "clusters and boxes": "cluster [ms]",
    "crops": "crop [ms]",
    "inference": "infer [ms]",
    "vote": "vote [ms]",
}
"""What the detector says of itself, in the order of the work."""


class Spread(NamedTuple):
    """Of times [ms]."""

    p50: float
    p99: float
    worst: float
    number: int


class DriveFigures(NamedTuple):
    """error_m, error: of the end pose against the goal, in truth [m, rad]. clearance_m: the least on the way."""

    arrived: bool
    said: str
    pictures: int
    duration_s: float
    error_m: float
    error: float
    clearance_m: float
    touched: bool

    @property
    def good(self) -> bool:
        """Whether it did all that it was to do."""
        return self.arrived and self.pictures > 0 and not self.touched


def drive_figures(result: EndToEnd) -> DriveFigures:
    """Of the drive."""
    live, laptop = result.live, result.laptop
    last, goal = live.trail[-1], live.setup.world.goal
    begun_ns = laptop.get("begun_ns", last.stamp_ns)
    off = last.pose.relative_to(goal)
    return DriveFigures(
        arrived=laptop.get("state") == "arrived",
        said=result.trouble or laptop["reason"] or laptop["state"],
        pictures=sum(each["picture_ns"] is not None for each in laptop.get("inspections", ())),
        duration_s=(_stood_ns([moment.pose for moment in live.trail], live.trail) - begun_ns) / 1e9,
        error_m=math.hypot(off.x_m, off.y_m),
        error=abs(off.theta),
        clearance_m=live.clearance_m(),
        touched=live.touched,
    )


def latencies(result: EndToEnd) -> Dict[str, Spread]:
    """From capture, by the simulation and by the camera driver's stamp, to when the laptop knew the objects."""
    frames = [frame for frame in result.laptop["frames"] if frame[1] >= result.laptop["begun_ns"]]
    stamped = np.array([frame[0] for frame in frames], np.int64)
    known = np.array([frame[1] for frame in frames], np.int64)
    captured = result.live.captured_ns(stamped)
    return {
        "capture to the laptop": spread(known - captured),
        "driver's stamp to the laptop": spread(known - stamped),
        "capture to the driver's stamp (simulated camera)": spread(stamped - captured),
    }


def stages_ms(result: EndToEnd) -> Dict[str, float]:
    """Medians over the drive of what the detector said of its newest looks."""
    said: List[Mapping[str, Any]] = [
        figures["detector"]
        for ns, figures in result.laptop["figures"]
        if ns >= result.laptop["begun_ns"] and figures.get("detector")
    ]
    return {what: median(float(each[name]) for each in said) for what, name in STAGES.items() if said}


def spread(times_ns: npt.NDArray[np.int64]) -> Spread:
    """Raises ValueError of none."""
    if not len(times_ns):
        raise ValueError("no frame came during the drive")
    p50, p99 = np.percentile(times_ns, (50, 99)) / 1e6
    return Spread(float(p50), float(p99), float(times_ns.max()) / 1e6, len(times_ns))


def _stood_ns(poses: Sequence[Pose2D], trail: Sequence[Any]) -> int:
    """When it came to where it is now."""
    moved = [i for i, pose in enumerate(poses) if pose != poses[-1]]
    return int(trail[moved[-1]].stamp_ns if moved else trail[0].stamp_ns)
