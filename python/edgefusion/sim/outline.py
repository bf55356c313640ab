# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Convex outlines in the plan: what a body covers of the ground at any height, and how far two of them are apart."""

from __future__ import annotations

from typing import Iterable

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.sim.floor_plan import distances_m
from edgefusion.sim.mesh import Part

Outline = npt.NDArray[np.float64]
"""Corners [n, 2] of a convex polygon, in order; two are a line, one is a point."""


def outline_of(parts: Iterable[Part]) -> Outline:
    """The smallest convex outline around all that is above or below."""
    points = np.concatenate([part.vertices[:, :2] for part in parts])
    return np.asarray(cv2.convexHull(np.ascontiguousarray(points, np.float32)), float).reshape(-1, 2)


def apart_m(a: Outline, b: Outline) -> float:
    """From one outline to the other; below 0: how far they would have to move to touch only."""
    axes = np.concatenate([_normals(a), _normals(b)])
    on_a, on_b = a @ axes.T, b @ axes.T
    between = np.maximum(on_b.min(axis=0) - on_a.max(axis=0), on_a.min(axis=0) - on_b.max(axis=0))
    deepest = float(between.max(initial=-np.inf))
    if len(axes) and deepest <= 0:
        return deepest
    return float(min(distances_m(a, _edges(b)).min(), distances_m(b, _edges(a)).min()))


def _edges(outline: Outline) -> Outline:
    """As segments [n, 4]."""
    return np.hstack([outline, np.roll(outline, -1, axis=0)])


def _normals(outline: Outline) -> Outline:
    """Across every edge, of length 1."""
    along = np.roll(outline, -1, axis=0) - outline
    length = np.hypot(along[:, 0], along[:, 1])
    kept, length = along[length > 0], length[length > 0]
    return np.stack([kept[:, 1], -kept[:, 0]], axis=1) / length[:, None]
