# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The plan of a world with what happened in it: objects, the way, where the robot was and where it saw something."""

from __future__ import annotations

import math
from textwrap import fill
from typing import Any, Mapping, Sequence

import numpy as np

from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.floor_plan import BUILDING
from edgefusion.sim.outline import outline_of
from edgefusion.sim.world import Point
from edgefusion.tools.drive import Moment
from edgefusion.tools.report_plots import Plot, Theme
from edgefusion.types import Pose2D

WIDTH_IN = 7.0
_MARGIN_M, _LINE = 0.4, 13


def plan_plot(
    world: BuiltWorld, trail: Sequence[Moment], verdicts: Mapping[str, bool], sightings: Sequence[Point]
) -> Plot:
    """verdicts: of the objects that were in view, by name, whether found and named right. sightings: their places."""

    def plot(figure: Any, theme: Theme) -> None:
        axis = figure.subplots()
        axis.set_aspect("equal")
        axis.set(xlabel="x [m]", ylabel="y [m]")
        _draw_world(axis, world, verdicts, theme)
        _draw_way(axis, world, trail, theme)
        if sightings:
            axis.plot(*np.array(sightings).T, "+", color=theme.ink, markersize=8, label="sightings", zorder=5)
        axis.legend(ncol=4, loc="lower center", bbox_to_anchor=(0.5, 1), borderaxespad=0.3)
        (x0, y0), (x1, y1) = extent_m(world)
        axis.set(xlim=(x0, x1), ylim=(y0, y1))

    return plot


def size_in(world: BuiltWorld) -> tuple[float, float]:
    """The figure's size for a plan of that shape."""
    (x0, y0), (x1, y1) = extent_m(world)
    return WIDTH_IN, float(np.clip(WIDTH_IN * (y1 - y0) / (x1 - x0) + 0.6, 3.0, 11.0))


def extent_m(world: BuiltWorld) -> Any:
    """Corners [2, 2] of all that is in the plan, with a margin."""
    segments = world.plan.segments.reshape(-1, 2)
    ends = [(world.world.start.x_m, world.world.start.y_m), (world.world.goal.x_m, world.world.goal.y_m)]
    points = np.vstack([segments, ends, np.array(world.world.route).reshape(-1, 2)])
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


def _write(axis: Any, text: str, point: Point, color: str, theme: Theme) -> None:
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.5, foreground=theme.ground)]
    axis.text(*point, text, color=color, fontsize=8, ha="center", va="center", path_effects=halo, zorder=6)


def _draw_way(axis: Any, world: BuiltWorld, trail: Sequence[Moment], theme: Theme) -> None:
    start, goal = world.world.start, world.world.goal
    way = np.array([(start.x_m, start.y_m), *world.world.route, (goal.x_m, goal.y_m)])
    axis.plot(*way.T, color=theme.faint, linewidth=1, marker="o", markersize=4, label="route", zorder=2)
    for name, label, color, style in (
        ("pose", "true path", theme.truth, "-"),
        ("believed", "odometry", theme.believed, "--"),
    ):
        poses = [getattr(moment, name) for moment in trail]
        points = np.array([(pose.x_m, pose.y_m) for pose in poses])
        axis.plot(*points.T, color=color, linestyle=style, linewidth=1.6, label=label, zorder=4)
    _draw_pose(axis, start, theme)
    _draw_pose(axis, goal, theme)


def _draw_pose(axis: Any, pose: Pose2D, theme: Theme) -> None:
    """A base from above: a circle with its direction."""
    from matplotlib.patches import Circle

    axis.add_patch(Circle((pose.x_m, pose.y_m), 0.2, facecolor="none", edgecolor=theme.ink, linewidth=1.1, zorder=4))
    tip = (pose.x_m + 0.35 * math.cos(pose.theta), pose.y_m + 0.35 * math.sin(pose.theta))
    axis.plot((pose.x_m, tip[0]), (pose.y_m, tip[1]), color=theme.ink, linewidth=1.1, zorder=4)
