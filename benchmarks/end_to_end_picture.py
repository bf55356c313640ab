# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A drive on the plan of its world, as a picture."""

from __future__ import annotations

import math
from pathlib import Path

from benchmarks.end_to_end_run import EndToEnd

from edgefusion.tools.plan_plot import plan_plot, size_in
from edgefusion.tools.report_plots import LIGHT


def draw_drive(path: Path, result: EndToEnd) -> None:
    """Writes a PNG: the true path, the odometry's, and where the robot stood before what it inspected."""
    from matplotlib.figure import Figure

    world, trail = result.live.built(), result.live.trail
    stops = [
        {"pose": (*each["pose"][:2], math.degrees(each["pose"][2])), "place_m": each["place_m"]}
        for each in result.laptop.get("inspections", ())
    ]
    figure = Figure(figsize=size_in(world, trail), layout="constrained")
    report = {"by_object": [], "sightings": [], "mission": {"inspections": stops}}
    plan_plot(world, trail, report)(figure, LIGHT)
    figure.savefig(path, dpi=110)
