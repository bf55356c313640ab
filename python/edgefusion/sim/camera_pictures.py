# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a world's camera sees, as the camera gives it: exposed, with noise, as a JPEG."""

from __future__ import annotations

from types import TracebackType

import cv2
import numpy as np

from edgefusion.sim.built_world import build
from edgefusion.sim.exposure import CameraSpec, balance, exposed
from edgefusion.sim.light import random_light
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.world import World
from edgefusion.types import Pose2D


class CameraPictures:
    """In one light, with one gain and tint, drawn by the seed. Raises RefusedError where Panda3D is missing."""

    def __init__(self, world: World, seed: int) -> None:
        self._rig, self._spec = Rig(), CameraSpec()
        self._renderer = Renderer(self._rig)
        self._renderer.show(build(world, self._rig.laser_height_m))
        self._rng = np.random.default_rng(seed)
        self._light = random_light(self._rng)
        self._balance = balance(self._spec, self._rng)

    def __enter__(self) -> CameraPictures:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._renderer.close()

    def jpeg(self, pose: Pose2D, turn_radps: float, quality: int) -> bytes:
        """From a base that stands there and turns so fast."""
        clean = self._renderer.image(pose, self._light)
        focal_px = float(self._rig.K[0, 0])
        image = exposed(self._spec, clean, focal_px, turn_radps, self._rng, self._balance)
        _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        return data.tobytes()
