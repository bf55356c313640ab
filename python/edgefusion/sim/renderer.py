# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The one renderer: a world as the rig's camera sees it, without noise, and which object is where in the picture.

Two scenes with the same surfaces: one lit and textured, one in which every object has a flat colour, its number.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.sim.building import sky
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.lens import lens_of
from edgefusion.sim.light import Light
from edgefusion.sim.panda import model_of, open_pipe
from edgefusion.sim.rig import Matrix, Rig
from edgefusion.sim.shadows import shadow_node
from edgefusion.types import Pose2D

Image = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.int32]

NOTHING = -1
"""In a mask: no object, but floor, walls or sky."""

MOST_THINGS = 250
"""Objects have a number of 8 bits in the renderer's masks."""

NEAR_M, FAR_M = 0.05, 120.0
_SNAP_PX = 0.25
"""The rasterizer snaps corners down to whole pixels, which moves edges by this much up and to the left on average;
measured in tests/test_renderer.py."""


class Renderer:
    """Draws one world at a time. Close it, or use it in a `with`: Panda3D keeps what it draws into until then.

    Raises RefusedError where Panda3D or a library that it needs is missing.
    """

    def __init__(self, rig: Rig) -> None:
        self._pipe = open_pipe()  # first: it says in one line what is missing
        from panda3d import core

        self._rig, self._lens = rig, lens_of(rig)
        self._engine = core.GraphicsEngine.get_global_ptr()
        self._lit = _View(self._engine, self._pipe, self._lens)
        self._flat = _View(self._engine, self._pipe, self._lens)
        self._numbered: list[Any] = []
        self._world: BuiltWorld | None = None

    def __enter__(self) -> Renderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Gives back what it drew into."""
        for view in (self._lit, self._flat):
            view.close()

    def show(self, world: BuiltWorld) -> None:
        """Takes a world, instead of the one before. Raises ValueError for one with more than MOST_THINGS objects."""
        if len(world.bodies) > MOST_THINGS:
            raise ValueError(f"world: expected at most {MOST_THINGS} objects, got {len(world.bodies)}")
        self._world = world
        for view in (self._lit, self._flat):
            view.clear()
        building = model_of(world.building, "building")
        self._numbered = []
        for number, body in enumerate(world.bodies):
            node = model_of(body, str(number))
            self._numbered.append(self._flat.add_flat(node, number + 1))
            self._lit.add(node)
        self._flat_building = self._flat.add_flat(building, 0)
        self._lit.add(building)
        for thing in world.world.things:
            self._lit.add(shadow_node(thing, world.size_m(thing)))

    def image(self, base: Pose2D, light: Light) -> Image:
        """BGR uint8 [height, width, 3], seen from a base that stands there."""
        T = self._rig.T_world_camera(base)
        self._lit.light(light)
        rendered = self._lit.draw(T, self._backdrop(T))
        sharp = self._lens.picture(rendered)
        return np.asarray(cv2.resize(sharp, self._rig.image_size, interpolation=cv2.INTER_AREA), np.uint8)

    def mask(self, base: Pose2D) -> Mask:
        """Which object each pixel shows, int32[2 * height, 2 * width], NOTHING elsewhere: twice the image's size, so
        that edges are good to half a pixel."""
        self._show_only(None)
        return self._numbers(base)

    def mask_alone(self, base: Pose2D, number: int) -> npt.NDArray[np.bool_]:
        """The object's pixels if nothing stood before it, bool of the mask's size."""
        self._show_only(number)
        return np.asarray(self._numbers(base) == number)

    def _show_only(self, number: int | None) -> None:
        for i, node in enumerate(self._numbered):
            node.show() if number is None or i == number else node.hide()
        self._flat_building.show() if number is None else self._flat_building.hide()

    def _numbers(self, base: Pose2D) -> Mask:
        rendered = self._flat.draw(self._rig.T_world_camera(base), None)
        numbers = self._lens.mask(np.ascontiguousarray(rendered[:, :, 2]))
        return numbers.astype(np.int32) - 1

    def _backdrop(self, T_world_camera: Matrix) -> Image | None:
        """The sky, where there is one. The camera is upright: the horizon is a row."""
        if self._world is None or self._world.world.ceiling_m is not None:
            return None
        forward = T_world_camera[:3, 2]
        pitch = float(np.arctan2(forward[2], np.hypot(forward[0], forward[1])))
        width, height = self._lens.size
        return sky(width, height, self._lens.centre[1] + self._lens.focal[1] * np.tan(pitch))


class _View:
    """A buffer, the camera that fills it and the scene before the camera."""

    def __init__(self, engine: Any, pipe: Any, lens: Any) -> None:
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
        self._lights: list[Any] = []

    def close(self) -> None:
        self._engine.remove_window(self._buffer)

    def clear(self) -> None:
        self._scene.remove_node()
        self._scene = self._root.attach_new_node("scene")

    def add(self, node: Any) -> None:
        node.reparent_to(self._scene)

    def add_flat(self, node: Any, number: int) -> Any:
        """A copy of the node that shares its surfaces, in one colour: the number is its red channel's value."""
        copy = node.copy_to(self._scene)
        copy.set_texture_off(1)
        copy.set_light_off(1)
        # The renderer rounds down: half a step above the number lands on it.
        copy.set_color((number + 0.5) / 256, 0, 0, 1, 1)
        return copy

    def light(self, light: Light) -> None:
        from panda3d import core

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


def _pinhole(lens: Any) -> Any:
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
