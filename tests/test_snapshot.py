# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One look from a driving robot: sensors and truth agree with each other."""

from __future__ import annotations

import numpy as np
import pytest

from edgefusion._core import project
from edgefusion.perception.motion import laser_motion
from edgefusion.sim.built_world import build
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.light import Light, random_light
from edgefusion.sim.random_world import random_world
from edgefusion.sim.rig import Rig
from edgefusion.sim.snapshot import FRAME_APART_NS, SCAN_NS, snapshot
from edgefusion.sim.viewpoints import viewpoint
from edgefusion.tools.geometry import calibration_of
from edgefusion.types import Twist2D

pytest.importorskip("panda3d", reason="the camera needs Panda3D (the extra 'sim')")
from edgefusion.sim.renderer import Renderer

RIG = Rig()
TWIST = Twist2D(0.4, 0.5)


@pytest.fixture(scope="module")
def scene():
    world = build(random_world(7, list(CATALOGUE.values())), RIG.laser_height_m)
    with Renderer(RIG) as renderer:
        renderer.show(world)
        yield world, renderer


def look(scene, seed: int, twist: Twist2D = TWIST, light: Light | None = None):
    world, renderer = scene
    rng = np.random.default_rng(seed)
    base = viewpoint(world, rng)
    return snapshot(world, renderer, RIG, base, twist, light or random_light(rng), rng)


def test_the_same_seed_gives_the_same_bytes(scene) -> None:
    a, b, other = look(scene, 1), look(scene, 1), look(scene, 2)
    assert a.frame.image.tobytes() == b.frame.image.tobytes()
    assert a.scan.ranges_m.tobytes() == b.scan.ranges_m.tobytes()
    assert a.truth == b.truth
    assert a.frame.image.tobytes() != other.frame.image.tobytes()


def test_the_frame_is_taken_near_the_scan_and_the_motion_is_what_lies_between(scene) -> None:
    for seed in range(6):
        shot = look(scene, seed)
        assert shot.scan.stamp_ns == SCAN_NS
        apart_ns = shot.frame.stamp_ns - shot.scan.stamp_ns
        assert abs(apart_ns) <= FRAME_APART_NS
        assert shot.motion.theta == pytest.approx(TWIST.w_radps * apart_ns / 1e9)


def test_beams_projected_with_the_motion_fall_onto_the_object_that_they_met(scene) -> None:
    calibration = calibration_of(RIG)
    inside = total = 0
    for seed in range(8):
        shot = look(scene, seed)
        T = calibration.T_camera_laser @ laser_motion(shot.motion, calibration.T_base_laser)
        for truth in shot.truth:
            if truth.occlusion > 0.01:
                continue
            beams = np.flatnonzero((shot.owners == truth.index) & np.isfinite(shot.scan.ranges_m))
            ranges_m, angles = shot.scan.ranges_m[beams], shot.scan.angles[beams]
            points = np.stack([ranges_m * np.cos(angles), ranges_m * np.sin(angles), 0 * angles], axis=1)
            pixels, _ = project(points, calibration.camera, T)
            x0, y0, x1, y1 = truth.box
            width, height = RIG.image_size
            in_image = (pixels >= 0).all(axis=1) & (pixels < (width, height)).all(axis=1)
            within = (pixels >= (x0 - 3, y0 - 3)).all(axis=1) & (pixels < (x1 + 3, y1 + 3)).all(axis=1)
            inside += int((within & in_image).sum())
            total += int(in_image.sum())
    assert total > 200
    assert inside > 0.97 * total


def test_the_true_range_is_the_nearest_of_the_beams_that_meet_the_object(scene) -> None:
    errors_m = []
    for seed in range(8):
        shot = look(scene, seed, Twist2D())
        for truth in shot.truth:
            ranges_m = shot.scan.ranges_m[(shot.owners == truth.index) & np.isfinite(shot.scan.ranges_m)]
            if truth.beams >= 8 and truth.occlusion < 0.01 and 0 < truth.box[0] and truth.box[2] < RIG.image_size[0]:
                errors_m.append(float(ranges_m.min()) - truth.range_m)
    assert len(errors_m) >= 5
    assert abs(np.median(errors_m)) < 0.02
