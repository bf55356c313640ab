# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The soft dark patch on the floor around an object: without it everything seems to float."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from edgefusion.sim.kinds.kind import Size
from edgefusion.sim.mesh import Part, plain
from edgefusion.sim.panda import part_node, texture_of
from edgefusion.sim.world import Thing

_ABOVE_FLOOR_M = 0.004
_BEYOND = 1.35
_PX, _DARKNESS = 64, 150


def shadow_node(thing: Thing, size_m: Size) -> Any:
    """A node with the patch, in the world's frame."""
    from panda3d import core

    half = np.asarray(size_m[:2]) * _BEYOND / 2
    corners = np.array([(x * half[0], y * half[1], _ABOVE_FLOOR_M) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    patch = Part(corners, np.tile((0.0, 0.0, 1.0), (4, 1)), uv, faces, plain(0))
    path = core.NodePath(part_node(patch))
    path.set_texture(texture_of(np.zeros((_PX, _PX, 3), np.uint8), _opacity()))
    path.set_transparency(core.TransparencyAttrib.M_alpha)
    path.set_light_off(1)
    path.set_depth_write(False)
    path.set_pos_hpr(thing.pose.x_m, thing.pose.y_m, 0, np.degrees(thing.pose.theta), 0, 0)
    return path


def _opacity() -> Any:
    inner = round(_PX / _BEYOND)
    dark = np.zeros((_PX, _PX), np.float32)
    margin = (_PX - inner) // 2
    dark[margin:-margin, margin:-margin] = _DARKNESS
    return np.asarray(cv2.GaussianBlur(dark, (0, 0), _PX * 0.07), np.float32).reshape(_PX, _PX).astype(np.uint8)
