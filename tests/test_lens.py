# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The distorted picture shows in every pixel what the camera model projects there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from edgefusion._core import Camera, project
from edgefusion.sim.lens import SUPERSAMPLING, Lens, lens_of
from edgefusion.sim.rig import Rig

RIG = Rig()
WIDE = replace(RIG, distortion=(-0.2, 0.05, 0.001, -0.001, 0.0))


def positions(lens: Lens) -> np.ndarray:
    """Where each pixel of the supersampled image lies in the rendered picture, [height, width, 2]."""
    width, height = lens.size
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    return np.stack([lens.picture(x), lens.picture(y)], axis=-1).astype(float)


@pytest.mark.parametrize(("rig", "worst_px"), [(RIG, 0.2), (WIDE, 0.45)], ids=["default", "wide"])
def test_every_pixel_shows_what_the_camera_model_projects_there(rig: Rig, worst_px: float) -> None:
    lens = lens_of(rig)
    seen = (positions(lens) - lens.centre) / lens.focal
    rays = np.concatenate([seen, np.ones((*seen.shape[:2], 1))], axis=2).reshape(-1, 3)
    pixels, _ = project(rays, Camera(rig.K, list(rig.distortion)), np.eye(4))
    found = SUPERSAMPLING * (pixels.reshape(seen.shape) + 0.5) - 0.5
    height, width = seen.shape[:2]
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    off = found - np.stack([x, y], axis=-1)
    assert (width, height) == tuple(SUPERSAMPLING * side for side in rig.image_size)
    assert np.abs(off).max() < worst_px
    assert np.abs(off.mean(axis=(0, 1))).max() < 0.02


def test_a_pinhole_picture_is_left_as_it_is_rendered() -> None:
    lens = lens_of(replace(RIG, distortion=()))
    rendered = np.random.default_rng(0).integers(0, 256, (960, 1280, 3)).astype(np.uint8)
    assert lens.picture(rendered) is rendered
    assert lens.size == (1280, 960)


def test_a_mask_is_taken_from_the_nearest_pixel_not_mixed() -> None:
    lens = lens_of(RIG)
    width, height = lens.size
    stripes = np.tile(np.array([0, 200], np.uint8), (height, width // 2 + 1))[:, :width]
    assert set(np.unique(lens.mask(np.ascontiguousarray(stripes))).tolist()) == {0, 200}
