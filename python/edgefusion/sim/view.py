# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A scene before a pinhole camera, and the buffer that the camera fills."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.sim.lens import Lens
from edgefusion.sim.light import Light
from edgefusion.sim.panda import Node, Pipe
from edgefusion.sim.rig import Matrix

Image = npt.NDArray[np.uint8]

NEAR_M, FAR_M = 0.05, 120.0
_SNAP_PX = 0.25
"""The rasterizer snaps corners down to whole pixels, which moves edges by this much up and to the left on average;
measured in tests/test_renderer.py."""


class View:
    """A buffer, the camera that fills it and the scene before the camera."""

    def __init__(self, engine: Any, pipe: Pipe, lens: Lens) -> None:
        from panda3d import core

        self._engine, self._size = engine, lens.size
        width, height = lens.size
        fb = core.FrameBufferProperties()
        fb.set_rgba_bits(8, 8, 8, 8)
        fb.set_depth_bits(24)
        size = core.WindowProperties.size(width, height)
        self._buffer = engine.make_output(pipe, "view", 0, fb, size, core.GraphicsPipe.BF_refuse_window)
        self._texture = core.Texture()
        self._buffer.add_render_texture(self._texture, core.GraphicsOutput.RTM_copy_ram)
        self._buffer.set_active(False)
        self._buffer.set_clear_color_active(True)
        self._buffer.set_clear_color((0, 0, 0, 0))
        self._root = core.NodePath("root")
        self._camera = self._root.attach_new_node(core.Camera("camera", _pinhole(lens)))
        self._buffer.make_display_region().set_camera(self._camera)
        self._scene = self._root.attach_new_node("scene")
        self._lights: list[Node] = []
        self._lit_by: Light | None = None

    def close(self) -> None:
        """Gives the buffer back."""
        self._engine.remove_window(self._buffer)

    def clear(self) -> None:
        """Empties the scene."""
        self._scene.remove_node()
        self._scene = self._root.attach_new_node("scene")

    def add(self, node: Node) -> None:
        """Puts a node, in the world's frame, into the scene."""
        node.reparent_to(self._scene)

    def add_flat(self, node: Node, number: int) -> Node:
        """A copy of the node that shares its surfaces, in one colour: the number is its red channel's value."""
        copy = node.copy_to(self._scene)
        copy.set_texture_off(1)
        copy.set_light_off(1)
        # The renderer rounds down: half a step above the number lands on it.
        copy.set_color((number + 0.5) / 256, 0, 0, 1, 1)
        return copy

    def light(self, light: Light) -> None:
        """Lights the scene, instead of the light before."""
        from panda3d import core

        if light == self._lit_by:
            return  # new lamps mean new states of every surface, which Panda3D keeps
        self._lit_by = light
        self._root.clear_light()
        for node in self._lights:
            node.remove_node()
        ambient, lamp = core.AmbientLight("ambient"), core.DirectionalLight("lamp")
        ambient.set_color((*light.ambient, 1))
        lamp.set_color((*light.lamp, 1))
        self._lights = [self._root.attach_new_node(each) for each in (ambient, lamp)]
        self._lights[1].set_hpr(np.degrees(light.heading) - 90, np.degrees(light.pitch), 0)
        for node in self._lights:
            self._root.set_light(node)

    def draw(self, T_world_camera: Matrix, backdrop: Image | None) -> Image:
        """BGR uint8 [height, width, 3] of the pinhole; the backdrop shows where nothing was drawn."""
        from panda3d import core

        R, t = T_world_camera[:3, :3], T_world_camera[:3, 3]
        # Panda3D's camera: x right, y forward, z up; the rows of its matrices are what the axes become.
        rows = np.eye(4)
        rows[:3, :3], rows[3, :3] = (R[:, 0], R[:, 2], -R[:, 1]), t
        self._camera.set_mat(core.LMatrix4(*rows.ravel().tolist()))
        self._buffer.set_active(True)
        self._engine.render_frame()
        self._buffer.set_active(False)  # or the other view's frames would draw this one, too
        width, height = self._size
        bgra = np.frombuffer(self._texture.get_ram_image(), np.uint8).reshape(height, width, 4)
        upright = np.asarray(cv2.flip(bgra, 0))  # its rows come from below
        picture = np.asarray(cv2.cvtColor(upright, cv2.COLOR_BGRA2BGR), np.uint8)
        if backdrop is not None:
            empty = upright[:, :, 3] == 0
            picture[empty] = backdrop[empty]
        return picture


def _pinhole(lens: Lens) -> Any:
    from panda3d import core

    (width, height), (fx, fy), (cx, cy) = lens.size, lens.focal, lens.centre
    pinhole = core.PerspectiveLens()
    pinhole.set_film_size(width, height * fx / fy)
    pinhole.set_focal_length(fx)
    # To the centre of the picture, whose pixels' centres are at whole numbers.
    x, y = cx + 0.5 + _SNAP_PX, cy + 0.5 + _SNAP_PX
    pinhole.set_film_offset(width / 2 - x, (y - height / 2) * fx / fy)
    pinhole.set_near_far(NEAR_M, FAR_M)
    return pinhole
