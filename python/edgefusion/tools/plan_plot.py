# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The plan of a world with what happened in it: objects, the way, where the robot stopped and what it saw where."""

from __future__ import annotations

import math
from textwrap import fill
from typing import Any, Mapping, Sequence

import numpy as np

from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.floor_plan import BUILDING
from edgefusion.sim.outline import outline_of
from edgefusion.sim.world import Point
from edgefusion.tools.drive_log import Moment
from edgefusion.tools.report_plots import Plot, Theme

WIDTH_IN = 7.0
_MARGIN_M, _LINE = 0.4, 13
_RADIUS_M, _NOSE_M = 0.2, 0.38
"""Of a base as it is drawn."""


def plan_plot(world: BuiltWorld, trail: Sequence[Moment], report: Mapping[str, Any]) -> Plot:
    """report: report.json's, of which this draws sightings, inspections, and whether objects were named right."""

    def plot(figure: Any, theme: Theme) -> None:
        axis = figure.subplots()
        axis.set_aspect("equal")
        axis.set(xlabel="x [m]", ylabel="y [m]")
        verdicts = {row["name"]: row["found"] and row["named"] for row in report["by_object"] if row["counts"]}
        _draw_world(axis, world, verdicts, theme)
        _draw_way(axis, world, trail, theme)
        _draw_inspections(axis, report["mission"]["inspections"], theme)
        places = np.array([row["place_m"] for row in report["sightings"]])
        if len(places):
            axis.plot(*places.T, "+", color=theme.ink, markersize=8, label="sightings", zorder=5)
        axis.legend(ncol=4, loc="lower center", bbox_to_anchor=(0.5, 1), borderaxespad=0.3)
        (x0, y0), (x1, y1) = extent_m(world, trail)
        axis.set(xlim=(x0, x1), ylim=(y0, y1))

    return plot


def size_in(world: BuiltWorld, trail: Sequence[Moment]) -> tuple[float, float]:
    """The figure's size for a plan of that shape."""
    (x0, y0), (x1, y1) = extent_m(world, trail)
    return WIDTH_IN, float(np.clip(WIDTH_IN * (y1 - y0) / (x1 - x0) + 0.6, 3.0, 11.0))


def extent_m(world: BuiltWorld, trail: Sequence[Moment]) -> Any:
    """Corners [2, 2] of all that is in the plan, with a margin."""
    ends = [(world.world.start.x_m, world.world.start.y_m), (world.world.goal.x_m, world.world.goal.y_m)]
    way = [(moment.pose.x_m, moment.pose.y_m) for moment in trail]
    points = np.vstack([world.plan.segments.reshape(-1, 2), ends, way])
    return np.array([points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M])


def _draw_world(axis: Any, world: BuiltWorld, verdicts: Mapping[str, bool], theme: Theme) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon

    walls = world.plan.of(BUILDING).reshape(-1, 2, 2)
    axis.add_collection(LineCollection(list(walls), colors=theme.ink, linewidths=1.2))
    for index, thing in enumerate(world.world.things):
        verdict = verdicts.get(thing.name)
        color = theme.faint if verdict is None else theme.good if verdict else theme.bad
        axis.add_patch(Polygon(outline_of(world.bodies[index]), facecolor=theme.fill, edgecolor=color, linewidth=1.4))
        mark = {None: "", True: "\u00a0✓", False: "\u00a0✗"}[verdict]
        name, middle = fill(thing.name, _LINE) + mark, (thing.pose.x_m, thing.pose.y_m)
        _write(axis, name, middle, color if mark else theme.ink, theme)


def _write(axis: Any, text: str, point: Point, color: str, theme: Theme, align: str = "center") -> None:
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.5, foreground=theme.ground)]
    axis.text(*point, text, color=color, fontsize=8, ha=align, va="center", path_effects=halo, zorder=6)


def _draw_way(axis: Any, world: BuiltWorld, trail: Sequence[Moment], theme: Theme) -> None:
    for name, label, color, style in (
        ("pose", "true path", theme.truth, "-"),
        ("believed", "odometry", theme.believed, "--"),
    ):
        poses = [getattr(moment, name) for moment in trail]
        points = np.array([(pose.x_m, pose.y_m) for pose in poses])
        axis.plot(*points.T, color=color, linestyle=style, linewidth=1.6, label=label, zorder=4)
    for text, pose in (("start", world.world.start), ("goal", world.world.goal)):
        _draw_base(axis, (pose.x_m, pose.y_m), pose.theta, theme.ink)
        behind = (pose.x_m - _NOSE_M * math.cos(pose.theta), pose.y_m - _NOSE_M * math.sin(pose.theta))
        _write(axis, text, behind, theme.ink, theme, "right" if math.cos(pose.theta) > 0 else "left")


def _draw_inspections(axis: Any, inspections: Sequence[Mapping[str, Any]], theme: Theme) -> None:
    """Where the robot stood, and the line to where it believes the object to be."""
    for number, row in enumerate(inspections):
        (x_m, y_m, degrees), place = row["pose"], row["place_m"]
        label = None if number else "inspection"
        axis.plot((x_m, place[0]), (y_m, place[1]), color=theme.good, linewidth=1.4, linestyle=":", label=label)
        _draw_base(axis, (x_m, y_m), math.radians(degrees), theme.good)


def _draw_base(axis: Any, point: Point, theta: float, color: str) -> None:
    """A base from above: a circle with its direction."""
    from matplotlib.patches import Circle

    axis.add_patch(Circle(point, _RADIUS_M, facecolor="none", edgecolor=color, linewidth=1.2, zorder=4))
    tip = (point[0] + _NOSE_M * math.cos(theta), point[1] + _NOSE_M * math.sin(theta))
    axis.plot((point[0], tip[0]), (point[1], tip[1]), color=color, linewidth=1.2, zorder=4)
