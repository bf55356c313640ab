# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The renderer puts things where the camera model says, gives the same bytes every time, and says what it lacks."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Iterator

import numpy as np
import pytest

from edgefusion._core import Camera, project
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.kinds.kind import Kind
from edgefusion.sim.lens import SUPERSAMPLING
from edgefusion.sim.light import Light
from edgefusion.sim.mesh import Part, quad
from edgefusion.sim.renderer import MOST_THINGS, NOTHING, Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.world import Thing, Wall, World
from edgefusion.sim.world_file import load_world
from edgefusion.types import Pose2D
from sim_scenes import built, crate, outline_points, panel, skip_without_renderer

skip_without_renderer()

RIG = Rig()
LENSES = {"pinhole": (), "default": RIG.distortion, "wide": (-0.2, 0.05, 0.0, 0.0, 0.0)}
EVEN = Light(ambient=(1, 1, 1), lamp=(0, 0, 0))
HERE = Pose2D()
BEHIND = Wall((5.0, -6.0), (5.0, 6.0), 3.0, 0.1, "plaster")


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    with Renderer(RIG) as shared:
        yield shared


def furnished(order: int = 1) -> BuiltWorld:
    """A room with three objects, one before another, in either order."""
    names = ("oscilloscope", "barrel", "crate")
    places = ((2.4, 0.3), (3.2, 0.6), (2.9, -0.8))
    things = [Thing(name, CATALOGUE[name], Pose2D(x, y, np.pi), 5) for name, (x, y) in zip(names, places)]
    world = World("room", 4, "tiles", 2.5, (BEHIND,), tuple(things[::order]), HERE, HERE)
    return build(world, RIG.laser_height_m)


def pixels_of(points: np.ndarray, rig: Rig) -> np.ndarray:
    T_camera_world = np.linalg.inv(rig.T_world_camera(HERE))
    return np.asarray(project(points, Camera(rig.K, list(rig.distortion)), T_camera_world)[0])


def edges_of(mask: np.ndarray, scale: int) -> np.ndarray:
    """Where what is set begins and ends, (x0, y0, x1, y1) in the image's pixels, their centres at whole numbers."""
    rows, columns = np.nonzero(mask)
    return np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]) / scale - 0.5


def squares(rng: np.random.Generator, rig: Rig) -> list[Thing]:
    """White squares all over the picture, none before another, at any distance."""
    eye = rig.T_world_camera(HERE)[:3, 3]
    things = []
    for across in (-0.45, -0.15, 0.15, 0.45):
        for up in (-0.12, 0.12, 0.36):
            x = rng.uniform(1.9, 2.9)
            y, z = (x * (share + rng.uniform(-0.03, 0.03)) for share in (across, up))
            things.append(panel(eye[0] + x, eye[1] + y, 0.3, eye[2] + z - 0.15, eye[2] + z + 0.15))
    return things


def edges_in(renderer: Renderer, rig: Rig, seed: int) -> np.ndarray:
    """The squares' edges in the mask, in the picture, and where they belong: [3, squares, 4]."""
    things = squares(np.random.default_rng(seed), rig)
    renderer.show(built(things, ceiling_m=3.0))
    mask, white = renderer.mask(HERE), renderer.image(HERE, EVEN).min(axis=2) > 245
    found = []
    for index, thing in enumerate(things):
        pixels = pixels_of(outline_points(thing), rig)
        wanted = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
        x0, y0 = wanted[:2].astype(int) - 4
        x1, y1 = wanted[2:].astype(int) + 5
        around = np.zeros_like(white)
        around[y0:y1, x0:x1] = white[y0:y1, x0:x1]
        found.append((edges_of(mask == index, SUPERSAMPLING), edges_of(around, 1), wanted))
    return np.array(found).transpose(1, 0, 2)


@pytest.fixture(scope="module", params=sorted(LENSES))
def errors_px(request: pytest.FixtureRequest) -> tuple[np.ndarray, np.ndarray]:
    """How far the edges of 48 squares are from where they belong, in the mask and in the picture, [48, 4] each."""
    rig = replace(RIG, distortion=LENSES[request.param])
    with Renderer(rig) as renderer:
        in_mask, in_picture, wanted = np.concatenate([edges_in(renderer, rig, seed) for seed in range(4)], axis=1)
    return in_mask - wanted, in_picture - wanted


def middles(errors: np.ndarray) -> np.ndarray:
    return np.asarray((errors[:, :2] + errors[:, 2:]) / 2)


def test_corners_are_where_the_camera_projects_them(errors_px: tuple[np.ndarray, np.ndarray]) -> None:
    in_mask = np.abs(errors_px[0])
    assert np.percentile(in_mask, 90) < 0.55
    assert in_mask.max() < 0.8
    assert np.percentile(np.abs(middles(errors_px[0])), 95) < 0.4


def test_there_is_no_bias(errors_px: tuple[np.ndarray, np.ndarray]) -> None:
    in_mask, in_picture = errors_px
    for errors in (in_mask, in_picture):
        assert np.abs(errors.mean(axis=0)).max() < 0.3
    assert np.abs(middles(in_mask).mean(axis=0)).max() < 0.08
    assert np.abs(middles(in_picture).mean(axis=0)).max() < 0.15


def test_the_picture_agrees_with_the_mask(errors_px: tuple[np.ndarray, np.ndarray]) -> None:
    in_mask, in_picture = errors_px
    assert np.abs(in_picture - in_mask).max() <= 1.0


def test_the_same_world_gives_the_same_bytes_again_and_after_another_world(renderer: Renderer) -> None:
    pictures = []
    for world in (furnished(), built([panel(2, 0, 0.5, 0.2, 1)]), furnished()):
        renderer.show(world)
        pictures.append((renderer.image(HERE, Light()).tobytes(), renderer.mask(HERE).tobytes()))
    assert pictures[0] == pictures[2] != pictures[1]


HASH = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
from test_renderer import HERE, RIG, Light, Renderer, furnished
with Renderer(RIG) as renderer:
    renderer.show(furnished())
    print(hashlib.sha256(renderer.image(HERE, Light()).tobytes() + renderer.mask(HERE).tobytes()).hexdigest())
"""


def test_another_process_gives_the_same_bytes(renderer: Renderer) -> None:
    renderer.show(furnished())
    here = hashlib.sha256(renderer.image(HERE, Light()).tobytes() + renderer.mask(HERE).tobytes()).hexdigest()
    folder = str(Path(__file__).parent)
    done = subprocess.run([sys.executable, "-c", HASH, folder], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == here


def prepared_textures() -> int:
    """How many textures Panda3D keeps for its renderer, those of all open ones together."""
    from panda3d import core

    engine = core.GraphicsEngine.get_global_ptr()
    contexts = {window.gsg.this: window.gsg.prepared_objects for window in engine.windows}
    return sum(objects.get_num_prepared_textures() for objects in contexts.values())


def test_worlds_that_were_shown_before_take_no_memory(renderer: Renderer) -> None:
    kept = []
    for _ in range(12):
        renderer.show(furnished())
        renderer.image(HERE, Light())
        kept.append(prepared_textures())
    assert kept[0] > 0
    assert max(kept[6:]) < max(kept[:6]) + 40  # a world has 30; those of the last few are kept for a while


def test_slices_of_one_painted_sheet_are_textures_of_their_own(renderer: Renderer) -> None:
    sheet = np.zeros((4, 8, 3), np.uint8)
    sheet[:, 4:] = 255

    def halves(rng: np.random.Generator) -> list[Part]:
        corners = [np.array([(0, a, 1), (0, b, 1), (0, b, 0.2), (0, a, 0.2)]) for a, b in ((-0.5, 0), (0, 0.5))]
        return [quad(corners[0], sheet[:, :4]), quad(corners[1], sheet[:, 4:])]

    renderer.show(built([Thing("halves", Kind("halves", "halves", (0.01, 1, 1), halves), Pose2D(2, 0, np.pi), 0)]))
    thing = renderer.mask(HERE)[::SUPERSAMPLING, ::SUPERSAMPLING] == 0
    shown = renderer.image(HERE, EVEN)[thing].mean(axis=1)
    assert np.mean(shown < 10) == pytest.approx(0.5, abs=0.02)
    assert np.mean(shown > 245) == pytest.approx(0.5, abs=0.02)


def test_the_order_of_the_objects_does_not_matter(renderer: Renderer) -> None:
    renderer.show(furnished())
    picture, mask = renderer.image(HERE, Light()), renderer.mask(HERE)
    renderer.show(furnished(order=-1))
    np.testing.assert_array_equal(renderer.image(HERE, Light()), picture)
    last = mask.max()
    np.testing.assert_array_equal(renderer.mask(HERE), np.where(mask == NOTHING, NOTHING, last - mask))


def test_light_and_shade_change_the_picture_and_not_the_mask(renderer: Renderer) -> None:
    renderer.show(furnished())
    bright, mask = renderer.image(HERE, EVEN), renderer.mask(HERE)
    assert renderer.image(HERE, Light()).mean() < bright.mean() - 10
    np.testing.assert_array_equal(renderer.mask(HERE), mask)


def test_a_masks_number_is_the_objects_also_beyond_128(renderer: Renderer) -> None:
    eye = RIG.T_world_camera(HERE)[:3, 3]
    grid = [(across, up) for across in np.linspace(-1.3, 1.3, 25) for up in np.linspace(-0.4, 0.9, 10)]
    things = [panel(eye[0] + 3, y, 0.08, eye[2] + z - 0.05, eye[2] + z + 0.05) for y, z in grid]
    assert len(things) == MOST_THINGS == 250
    renderer.show(built(things))
    mask = renderer.mask(HERE)
    middles = pixels_of(np.array([(eye[0] + 3, y, eye[2] + z) for y, z in grid]), RIG)
    columns, rows = np.round(SUPERSAMPLING * (middles + 0.5) - 0.5).astype(int).T
    np.testing.assert_array_equal(mask[rows, columns], np.arange(250))


def test_a_picture_before_any_world_is_refused() -> None:
    with Renderer(RIG) as empty:
        for picture in (lambda: empty.image(HERE, EVEN), lambda: empty.mask(HERE), lambda: empty.mask_alone(HERE, 0)):
            with pytest.raises(RuntimeError, match=r"^renderer: expected show\(world\) before a picture$"):
                picture()


def test_more_objects_than_a_mask_can_number_are_refused(renderer: Renderer) -> None:
    world = built([panel(3, i, 0.1, 0.2, 0.4) for i in range(MOST_THINGS + 1)])
    with pytest.raises(ValueError, match=r"^world: expected at most 250 objects, got 251$"):
        renderer.show(world)


def test_a_mask_alone_ignores_what_stands_before_the_object(renderer: Renderer) -> None:
    behind, before = panel(3.0, 0, 0.6, 0.2, 1.0), panel(1.5, 0, 0.1, 0.0, 1.2)
    renderer.show(built([behind]))
    free = renderer.mask(HERE) == 0
    renderer.show(built([behind, before], walls=[Wall((2.0, -3.0), (2.0, -0.1), 2.0, 0.1, "brick")]))
    shows = renderer.mask(HERE) == 0
    np.testing.assert_array_equal(renderer.mask_alone(HERE, 0), free)
    assert 0.1 < shows.sum() / free.sum() < 0.6
    assert not (shows & ~free).any()
    np.testing.assert_array_equal(renderer.mask(HERE) == 0, shows)  # everything is drawn again afterwards


def test_an_object_behind_the_camera_is_not_in_the_mask(renderer: Renderer) -> None:
    renderer.show(built([crate("near", 2, 0, (0.4, 0.4, 0.8))]))
    assert (renderer.mask(HERE) == 0).any()
    assert (renderer.mask(Pose2D(0, 0, np.pi)) == NOTHING).all()


def test_the_sky_is_only_where_there_is_no_ceiling(renderer: Renderer) -> None:
    def top_rows(ceiling_m: float | None) -> np.ndarray:
        renderer.show(built([], ceiling_m, [BEHIND]))
        return np.asarray(renderer.image(HERE, EVEN)[:20].astype(int))

    blue_over_red = {ceiling_m: np.ptp(top_rows(ceiling_m), axis=2).mean() for ceiling_m in (None, 2.5)}
    assert blue_over_red[None] > 60 and blue_over_red[2.5] < 20


def test_indoors_there_is_no_sky_at_the_end_of_the_floor_either(renderer: Renderer) -> None:
    renderer.show(built([], 2.5))
    assert not renderer.image(HERE, EVEN)[round(float(RIG.K[1, 2])) - 2].any()


def test_the_sky_is_behind_everything(renderer: Renderer) -> None:
    renderer.show(built([], None, [BEHIND]))
    open_sky = renderer.image(HERE, EVEN)
    renderer.show(built([], 2.5, [BEHIND]))
    roofed = renderer.image(HERE, EVEN)
    changed = (open_sky != roofed).any(axis=2)
    horizon = round(float(RIG.K[1, 2]))
    assert changed[:20].all()
    assert not changed[horizon - 20 :].any()


def run(code: str, **environment: str) -> list[str]:
    """What a fresh process says, on both streams."""
    variables = {**os.environ, **environment}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=variables)
    assert done.returncode == 0, done.stderr
    return (done.stdout + done.stderr).splitlines()


OPEN = """
from edgefusion.errors import RefusedError
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
try:
    Renderer(Rig())
except RefusedError as error:
    print(error)
"""

NO_PANDA3D = """
import sys
class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "panda3d":
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Blocker())
"""

LASER = """
import numpy as np
from edgefusion.sim.built_world import build
from edgefusion.sim.laser import SimLaser
from edgefusion.sim.rig import Rig
from edgefusion.sim.world_file import load_world
rig = Rig()
built = build(load_world("laboratory"), rig.laser_height_m)
pose_at = lambda stamp_ns: rig.laser_pose(built.world.start)
scan, hits = SimLaser().scan(0, built.plan.segments, pose_at, np.random.default_rng(0))
print(len(scan.ranges_m), (built.plan.owners[hits[hits >= 0]] >= 0).sum() > 20)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Panda3D needs X11 on Linux only")
def test_without_libx11_one_line_names_it_and_how_to_get_it(tmp_path: Path) -> None:
    (tmp_path / "libX11.so.6").write_bytes(b"no library")  # the loader finds this one first, and gives up
    (line,) = run(OPEN, LD_LIBRARY_PATH=str(tmp_path))
    assert "libX11.so.6" in line and "apt-get install libx11-6" in line


def test_without_panda3d_one_line_says_how_to_get_it() -> None:
    (line,) = run(NO_PANDA3D + OPEN)
    assert "Panda3D" in line and "pip install 'edgefusion[sim]'" in line


def test_without_panda3d_worlds_are_built_and_scanned() -> None:
    assert run(NO_PANDA3D + LASER) == ["361 True"]


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_pictures_of_one_world_take_no_more_memory_however_many_they_are(renderer: Renderer) -> None:
    laboratory = load_world("laboratory")
    renderer.show(build(laboratory, RIG.laser_height_m))
    for _ in range(3):
        renderer.image(laboratory.start, Light())
    before = resident_mb()
    for _ in range(25):
        renderer.image(laboratory.start, Light())
    assert resident_mb() - before < 8


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
