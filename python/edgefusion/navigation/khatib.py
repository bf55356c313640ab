# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's potential: the goal attracts, and what is near repels (Khatib 1986).

U = attraction + repulsion; all in base_link, where the robot is at the origin, [m]. It has local minima: where the
two cancel out, the robot sticks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from edgefusion.config import KhatibConfig
from edgefusion.errors import RefusedError

Floats = npt.NDArray[np.float64]

CONIC_BEYOND_M = 1.0
"""U of the goal is a parabola up to here and a cone beyond: it pulls no harder from farther away."""

STEEPEST_M = 0.05
"""U of an obstacle is a cone nearer than this: it pushes no harder."""

GAP_M = 0.3
"""Neighbouring points farther apart than this belong to two things."""


class Descent(NamedTuple):
    """u_mps [2]: where to and how fast, by eq. (4). near: whether anything is within the threshold."""

    u_mps: Floats
    near: bool


def descend(goal_m: npt.ArrayLike, points_m: npt.ArrayLike, was_near: bool, config: KhatibConfig) -> Descent:
    """u = -k grad U, with the higher gain where nothing is within the threshold.

    goal_m [2]. points_m [n, 2]: what the laser met, in the order of its beams. was_near: near of the last time; what
    was near stays it until it is farther than the threshold by the hysteresis.
    """
    things_m = nearest_per_thing(points_m, config.threshold_m + config.hysteresis_m)
    rho_m = float(np.hypot(things_m[:, 0], things_m[:, 1]).min(initial=math.inf))
    near = rho_m < config.threshold_m + (config.hysteresis_m if was_near else 0.0)
    k = config.near_gain if near else config.far_gain
    return Descent(-k * gradient(goal_m, things_m, config), near)  # (4)


def potential(goal_m: npt.ArrayLike, things_m: npt.ArrayLike, config: KhatibConfig) -> float:
    """U at the origin. things_m [k, 2]: the nearest point of each."""
    d = math.hypot(*_checked("goal_m", goal_m, (2,)))
    outer = max(d - CONIC_BEYOND_M, 0.0)
    attraction = config.attraction * (d * d - outer * outer) / 2
    x, y = _checked("things_m", things_m, (-1, 2)).T
    rho = np.hypot(x, y)
    inverse, slope = _repulsion(rho, config)
    repulsion = config.repulsion * inverse * inverse / 2 + slope * np.minimum(rho - STEEPEST_M, 0)
    return attraction + float(repulsion.sum())


def gradient(goal_m: npt.ArrayLike, things_m: npt.ArrayLike, config: KhatibConfig) -> Floats:
    """grad U by the robot's place, at the origin [2]; zero where the goal or an obstacle itself is."""
    goal = _checked("goal_m", goal_m, (2,))
    things = _checked("things_m", things_m, (-1, 2))
    attraction = config.attraction * goal * min(1.0, CONIC_BEYOND_M / max(math.hypot(*goal), CONIC_BEYOND_M))
    rho = np.hypot(things[:, 0], things[:, 1])
    _, slope = _repulsion(rho, config)
    # rho falls where the robot moves towards a thing: its gradient is -things / rho.
    toward = things / np.maximum(rho, np.finfo(float).tiny)[:, None]
    return np.asarray(-attraction - slope @ toward)


def nearest_per_thing(points_m: npt.ArrayLike, reach_m: float, gap_m: float = GAP_M) -> Floats:
    """The nearest point of each thing within reach [k, 2]: a thing repels by its place, not by its number of beams.

    Points [n, 2] in the order of the beams; a thing is a run of them without a gap.
    """
    points = _checked("points_m", points_m, (-1, 2))
    rho = np.hypot(points[:, 0], points[:, 1])
    within = rho < reach_m
    points, rho = points[within], rho[within]
    steps = np.diff(points, axis=0)
    thing = np.concatenate([[0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]) > gap_m)])[: len(points)]
    nearest_first = np.lexsort((rho, thing))
    _, first = np.unique(thing[nearest_first], return_index=True)
    return points[nearest_first[first]]


def _repulsion(rho: Floats, config: KhatibConfig) -> tuple[Floats, Floats]:
    """1 / rho - 1 / rho0, and the derivative of 1/2 eta times its square; from STEEPEST_M on, 0 from rho0 on."""
    bounded = np.maximum(rho, STEEPEST_M)
    inverse = np.maximum(1 / bounded - 1 / config.threshold_m, 0)
    return inverse, -config.repulsion * inverse / (bounded * bounded)


def _checked(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Floats:
    """A float array of this shape, -1 for any size. Raises RefusedError for another, and for what is not finite."""
    array = np.asarray(values, float)
    if array.ndim != len(shape) or any(n not in (-1, m) for n, m in zip(shape, array.shape)):
        wanted = ["n" if n == -1 else n for n in shape]
        raise RefusedError(f"{name}: expected shape {wanted}, got {list(array.shape)}".replace("'", ""))
    if not np.isfinite(array).all():
        raise RefusedError(f"{name}: expected finite values, got {array[~np.isfinite(array)][0]}")
    return array
