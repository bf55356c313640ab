# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The one renderer: a world as the rig's camera sees it, without noise, and which object is where in the picture.

Two scenes with the same surfaces: one lit and textured, one in which every object has a flat colour, its number.
"""

from __future__ import annotations

from types import TracebackType

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.sim.building import sky
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.lens import lens_of
from edgefusion.sim.light import Light
from edgefusion.sim.panda import Node, collect_garbage, model_of, open_pipe
from edgefusion.sim.rig import Matrix, Rig
from edgefusion.sim.shadows import shadow_node
from edgefusion.sim.view import Image, View
from edgefusion.sim.world import World
from edgefusion.types import Pose2D

Mask = npt.NDArray[np.int32]

NOTHING = -1
"""In a mask: no object, but floor, walls or sky."""

MOST_THINGS = 250
"""Objects have a number of 8 bits in the renderer's masks."""


class Renderer:
    """Draws one world at a time. Close it, or use it in a `with`: Panda3D keeps what it draws into until then.

    Raises RefusedError where Panda3D or a library that it needs is missing. Pictures raise RuntimeError before a world
    was shown.
    """

    def __init__(self, rig: Rig) -> None:
        self._pipe = open_pipe()  # first: it says in one line what is missing
        from panda3d import core

        self._rig, self._lens = rig, lens_of(rig)
        self._engine = core.GraphicsEngine.get_global_ptr()
        self._lit = View(self._engine, self._pipe, self._lens)
        self._flat = View(self._engine, self._pipe, self._lens)
        self._numbered: list[Node] = []
        self._shown: World | None = None

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
        self._shown = world.world
        for view in (self._lit, self._flat):
            view.clear()
        collect_garbage()
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
        self._world()
        for i, node in enumerate(self._numbered):
            node.show() if number is None or i == number else node.hide()
        self._flat_building.show() if number is None else self._flat_building.hide()

    def _numbers(self, base: Pose2D) -> Mask:
        rendered = self._flat.draw(self._rig.T_world_camera(base), None)
        numbers = self._lens.mask(np.ascontiguousarray(rendered[:, :, 2]))
        return numbers.astype(np.int32) - 1

    def _world(self) -> World:
        if self._shown is None:
            raise RuntimeError("renderer: expected show(world) before a picture")
        return self._shown

    def _backdrop(self, T_world_camera: Matrix) -> Image | None:
        """The sky, where there is one. The camera is upright: the horizon is a row."""
        if self._world().ceiling_m is not None:
            return None
        forward = T_world_camera[:3, 2]
        pitch = float(np.arctan2(forward[2], np.hypot(forward[0], forward[1])))
        width, height = self._lens.size
        return sky(width, height, self._lens.centre[1] + self._lens.focal[1] * np.tan(pitch))
