# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A drive over its floor plan as a picture: where it went, and the hull every second."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from benchmarks.nav_run import TICK_NS, Run

from edgefusion.sim.hull import Hull
from edgefusion.types import Pose2D

Floats = npt.NDArray[np.float64]

_A_SECOND = 1_000_000_000 // TICK_NS


def draw_run(path: Path, title: str, segments: Floats, hull: Hull, goal: Pose2D, run: Run) -> None:
    """Writes a PNG. segments [m, 4]: the plan at the end of the drive; goal: in the world."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 8), layout="constrained")
    axis = figure.subplots()
    axis.set_aspect("equal")
    axis.add_collection(LineCollection(list(segments.reshape(-1, 2, 2)), colors="black", linewidths=1.0))
    shown = [*run.path[::_A_SECOND], run.path[-1]]
    hulls = [hull.at(Pose2D(*pose)) for pose in shown]
    colors = ["tab:blue"] * (len(hulls) - 1) + ["tab:red"]
    axis.add_collection(PolyCollection(hulls, facecolors="none", edgecolors=colors, linewidths=0.7))
    axis.plot(*run.path[:, :2].T, color="tab:blue", linewidth=1.2)
    axis.plot(goal.x_m, goal.y_m, "*", color="tab:green", markersize=14)
    axis.autoscale_view()
    reason = f" ({run.reason})" if run.reason else ""
    axis.set_title(f"{title}: {run.outcome.value}{reason} after {run.time_s:.1f} s")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100)
