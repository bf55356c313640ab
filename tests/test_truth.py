# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The ground truth of a frame: what both sensors see, where it is in the picture, how far, and how much of it."""

from __future__ import annotations

import math
from typing import Iterator

import numpy as np
import pytest

from edgefusion._core import Camera, project
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.lens import SUPERSAMPLING
from edgefusion.sim.mesh import size_of
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.truth import ObjectTruth, box_of, truth_of
from edgefusion.sim.world import Thing, Wall
from edgefusion.types import Pose2D
from sim_scenes import built, crate, panel, skip_without_renderer

skip_without_renderer()

RIG = Rig()
HERE = Pose2D()
SIZE = (0.4, 0.6, 0.8)
LASER_X_M = 0.1
INCREMENT = LaserSpec().angle_increment


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    with Renderer(RIG) as shared:
        yield shared


def look(renderer: Renderer, world: BuiltWorld, base: Pose2D = HERE, dropped: float = 0.0) -> list[ObjectTruth]:
    spec = LaserSpec(dropped=dropped)
    _, hits = SimLaser(spec).scan(0, world.plan.segments, lambda ns: RIG.laser_pose(base), np.random.default_rng(0))
    renderer.show(world)
    return truth_of(world, renderer, RIG, base, hits)


def projected(points: np.ndarray) -> np.ndarray:
    T_camera_world = np.linalg.inv(RIG.T_world_camera(HERE))
    return np.asarray(project(points, Camera(RIG.K, list(RIG.distortion)), T_camera_world)[0])


def box_around(things: list[Thing]) -> np.ndarray:
    """Of all edges of boxes, where the camera projects them."""
    steps = np.linspace(0, 1, 60)[:, None]
    corners = [part.vertices for thing in things for part in thing.placed(thing.kind.make(thing.seed, thing.size_m))]
    edges = [a + steps * (b - a) for face in corners for a, b in zip(face, np.roll(face, -1, axis=0))]
    pixels = projected(np.concatenate(edges))
    return np.concatenate([pixels.min(axis=0) + 0.5, pixels.max(axis=0) + 0.5])


def test_a_free_object_is_known_completely(renderer: Renderer) -> None:
    thing = crate("chest", 2.2, 0.1, SIZE)
    (truth,) = look(renderer, built([thing]))
    assert (truth.index, truth.name, truth.kind, truth.label) == (0, "chest", "box", "label of chest")
    np.testing.assert_allclose(truth.box, box_around([thing]), atol=1.0)
    assert truth.full_box == truth.box
    assert truth.range_m == pytest.approx(2.0 - LASER_X_M, abs=1e-6)
    assert truth.occlusion == 0
    bearings = np.arctan2([0.1 - 0.3, 0.1 + 0.3], 2.0 - LASER_X_M)
    assert truth.beams == math.floor(bearings[1] / INCREMENT) - math.ceil(bearings[0] / INCREMENT) + 1


def test_dropped_beams_count_too(renderer: Renderer) -> None:
    world = built([crate("chest", 2.2, 0.0, SIZE)])
    assert look(renderer, world, dropped=1.0)[0].beams == look(renderer, world)[0].beams > 10


def test_the_range_is_to_the_nearest_point_in_the_scan_plane_from_where_the_robot_is(renderer: Renderer) -> None:
    base, thing = Pose2D(0.3, -0.2, 0.1), crate("chest", 2.2, 0.0, SIZE, theta=math.pi / 4)
    (truth,) = look(renderer, built([thing]), base)
    laser = RIG.laser_pose(base)
    sides = np.linspace(-0.5, 0.5, 1001)[:, None]
    depth, width = np.diag(SIZE[:2])
    own = np.concatenate(
        [s * depth / 2 + sides * width for s in (-1, 1)] + [sides * depth + s * width / 2 for s in (-1, 1)]
    )
    c = math.sqrt(0.5)
    surface = own @ np.array([[c, c], [-c, c]]) + (2.2, 0.0)
    assert truth.range_m == pytest.approx(np.hypot(*(surface - (laser.x_m, laser.y_m)).T).min(), abs=1e-3)


def test_a_half_hidden_object_shows_half_of_it(renderer: Renderer) -> None:
    """The panel's edge and the camera are in the plane y = 0, which halves the object."""
    thing, before = crate("chest", 2.5, 0.0, SIZE), panel(1.2, 0.5, 1.0, 0.0, 1.2)
    truth = {each.name: each for each in look(renderer, built([thing, before]))}["chest"]
    assert truth.occlusion == pytest.approx(0.5, abs=0.02)
    whole = box_around([thing])
    np.testing.assert_allclose(truth.full_box, whole, atol=1.0)
    np.testing.assert_allclose(truth.box[1:], whole[1:], atol=1.0)
    assert truth.box[0] == pytest.approx(projected(np.array([[2.3, 0.0, 0.5]]))[0, 0] + 0.5, abs=1.5)


def test_the_box_of_an_object_that_reaches_over_the_border_ends_there(renderer: Renderer) -> None:
    left, middle = look(renderer, built([crate("left", 1.5, 1.0, SIZE), crate("middle", 1.6, -0.3, SIZE)]))[::-1]
    assert (left.name, left.box[0], left.full_box[0]) == ("left", 0, 0)
    assert middle.name == "middle" and middle.box[0] > 0


def test_an_object_that_a_wall_hides_is_absent(renderer: Renderer) -> None:
    hidden, free = crate("hidden", 3.5, 0.0, SIZE), crate("free", 2.0, -0.9, SIZE)
    wall = Wall((2.7, -0.6), (2.7, 1.5), 2.0, 0.1, "plaster")
    assert {each.name for each in look(renderer, built([hidden, free]))} == {"hidden", "free"}
    assert {each.name for each in look(renderer, built([hidden, free], walls=[wall]))} == {"free"}


def test_what_only_one_of_the_sensors_sees_is_absent(renderer: Renderer) -> None:
    below_the_scan = crate("low", 2.0, 0.0, (0.4, 0.4, 0.2))
    beside_the_picture = crate("beside", 0.8, 1.5, SIZE)
    behind = crate("behind", -2.0, 0.0, SIZE)
    assert look(renderer, built([below_the_scan, beside_the_picture, behind])) == []


def test_only_objects_with_a_truth_are_drawn_alone(renderer: Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[int] = []
    mask_alone = renderer.mask_alone

    def counted(base: Pose2D, number: int) -> np.ndarray:
        drawn.append(number)
        return mask_alone(base, number)

    monkeypatch.setattr(renderer, "mask_alone", counted)
    below_the_scan, seen = crate("low", 2.0, 0.6, (0.4, 0.4, 0.2)), crate("seen", 2.0, -0.4, SIZE)
    assert [each.index for each in look(renderer, built([below_the_scan, seen]))] == drawn == [1]


@pytest.mark.parametrize(("width_m", "seen"), [(0.003, 0), (0.06, 1)])
def test_an_object_of_which_hardly_a_pixel_shows_is_absent(renderer: Renderer, width_m: float, seen: int) -> None:
    """The beam straight ahead meets both of these; the picture has 130 pixels to the metre there."""
    found = look(renderer, built([panel(3.6, 0.0, width_m, 0.34, 0.36)]))
    assert len(found) == seen


def test_the_nearest_comes_first(renderer: Renderer) -> None:
    places = [(3.0, 0.7), (1.6, -0.4), (2.3, 0.2)]
    things = [crate(f"at {x}", x, y, (0.2, 0.2, 0.9)) for x, y in places]
    assert [each.name for each in look(renderer, built(things))] == ["at 1.6", "at 2.3", "at 3.0"]


def test_a_support_belongs_to_its_object(renderer: Renderer) -> None:
    thing = Thing("scope", CATALOGUE["oscilloscope"], Pose2D(2.0, 0.0, math.pi), 3)
    depth, _, height = size_of(thing.kind.make(3))
    (truth,) = look(renderer, built([thing]))
    foot = projected(np.array([[2.0 - depth / 2, 0.0, 0.0]]))[0, 1]
    assert truth.box[3] == pytest.approx(foot, abs=6)
    assert truth.range_m == pytest.approx(2.0 - depth / 2 - LASER_X_M, abs=0.06)
    assert height > RIG.laser_height_m


def test_a_box_is_around_all_that_is_set_and_never_empty() -> None:
    mask = np.zeros((480 * SUPERSAMPLING, 640 * SUPERSAMPLING), bool)
    mask[20:42, 60:100] = True
    mask[30, 110] = True
    assert box_of(mask) == (30, 10, 55, 21)  # half a pixel is rounded inwards
    thin = np.zeros_like(mask)
    thin[20:42, 110] = True
    assert box_of(thin) == (55, 10, 56, 21)
