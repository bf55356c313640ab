# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""x, y and theta over time: of a whole drive, and of its stop at an object."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np

from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.tools.drive_log import Moment
from edgefusion.tools.report_plots import Plot, Theme
from edgefusion.types import Pose2D

NAMES = ("x [m]", "y [m]", "theta [°]")

AROUND_S = 1.0
"""A stop's plot begins so long before the robot is told to stop, and ends so long after it goes on."""


def pose_plot(trail: Sequence[Moment], goal: Pose2D, stops: Sequence[InspectionResult]) -> Plot:
    """The truth, what the odometry said, the goal, and when the robot stood before an object."""

    def plot(figure: Any, theme: Theme) -> None:
        axes = figure.subplots(3, 1, sharex=True)
        end_theta = _columns([moment.pose for moment in trail])[2][-1]
        aims = (goal.x_m, goal.y_m, math.degrees(_near(goal.theta, math.radians(end_theta))))
        for axis, aim in zip(axes, aims):
            axis.axhline(aim, color=theme.good, linewidth=1.4, linestyle=":", label="goal")
        _draw(axes, trail, stops, theme)
        _finish(figure, axes)

    return plot


def stop_plot(trail: Sequence[Moment], stop: InspectionResult) -> Plot:
    """The same of the time about a stop, without the goal."""
    begin_s, end_s = stop.begun_ns / 1e9 - AROUND_S, stop.ended_ns / 1e9 + AROUND_S
    shown = [moment for moment in trail if begin_s <= moment.stamp_ns / 1e9 <= end_s]

    def plot(figure: Any, theme: Theme) -> None:
        axes = figure.subplots(3, 1, sharex=True)
        _draw(axes, shown, [stop], theme)
        _finish(figure, axes)

    return plot


def _draw(axes: Any, trail: Sequence[Moment], stops: Sequence[InspectionResult], theme: Theme) -> None:
    times = [moment.stamp_ns / 1e9 for moment in trail]
    true, believed = (_columns([getattr(moment, name) for moment in trail]) for name in ("pose", "believed"))
    stood = [(stop.stood_ns / 1e9, stop.ended_ns / 1e9) for stop in stops if stop.stood_ns is not None]
    for axis, name, truth, belief in zip(axes, NAMES, true, believed):
        for number, span in enumerate(stood):
            axis.axvspan(*span, color=theme.fill, linewidth=0, zorder=0, label=None if number else "stands")
        axis.plot(times, truth, color=theme.truth, linewidth=1.8, label="true")
        axis.plot(times, belief, color=theme.believed, linewidth=1.2, linestyle="--", label="odometry")
        axis.set_ylabel(name)
        axis.margins(x=0.01)


def _finish(figure: Any, axes: Any) -> None:
    axes[0].legend(ncol=4, loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.2)
    axes[2].set_xlabel("time [s]")
    figure.align_ylabels(axes)


def _columns(poses: Sequence[Pose2D]) -> tuple[Any, Any, Any]:
    theta = np.degrees(np.unwrap([pose.theta for pose in poses]))
    return np.array([pose.x_m for pose in poses]), np.array([pose.y_m for pose in poses]), theta


def _near(angle: float, other: float) -> float:
    """The same direction, in the turn of another angle."""
    return other + math.remainder(angle - other, 2 * math.pi)
