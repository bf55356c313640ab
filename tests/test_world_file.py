# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Worlds are strict files: what a world cannot be, or what the robot would run into, is refused with the names."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.sim.mesh import size_of
from edgefusion.sim.outline import apart_m
from edgefusion.sim.world import Wall
from edgefusion.sim.world_file import load_world, world_names
from edgefusion.types import Pose2D

HEAD = {
    "version": "1",
    "name": "'small'",
    "description": "'a room'",
    "seed": "7",
    "floor": "'carpet'",
    "start": "[0, 0, 0]",
    "goal": "[4, 0, 90]",
}
WALL = {"points": "[[-1, -2], [6, -2], [6, 3]]", "height_m": "2.5", "thickness_m": "0.1", "finish": "'plaster'"}
CRATE = {"kind": "'crate'", "pose": "[2, -1, 0]", "size": "[0.5, 0.6, 0.7]"}


def table(values: dict[str, str]) -> str:
    return "".join(f"{key} = {value}\n" for key, value in values.items())


def write(path: Path, *objects: dict[str, str], wall: dict[str, str] | None = None, **head: str) -> Path:
    text = table({**HEAD, **head}) + "[[walls]]\n" + table({**WALL, **(wall or {})})
    path.write_text(text + "".join("[[objects]]\n" + table({**CRATE, **each}) for each in objects), encoding="utf-8")
    return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "small.toml"


def assert_refused(path: Path, message: str) -> None:
    with pytest.raises(RefusedError, match=message) as refused:
        load_world(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert "\n" not in str(refused.value)


def test_a_file_is_read_as_it_says_and_degrees_become_radians(path: Path) -> None:
    world = load_world(write(path, {"pose": "[2, -1, 45]"}, ceiling_m="2.4"))
    assert (world.name, world.description, world.seed) == ("small", "a room", 7)
    assert (world.floor, world.ceiling_m) == ("carpet", 2.4)
    assert (world.start, world.goal) == (Pose2D(), Pose2D(4, 0, math.pi / 2))
    assert world.walls == (Wall((-1, -2), (6, -2), 2.5, 0.1, "plaster"), Wall((6, -2), (6, 3), 2.5, 0.1, "plaster"))
    (thing,) = world.things
    assert (thing.name, thing.kind.name, thing.pose) == ("crate 1", "crate", Pose2D(2, -1, math.pi / 4))
    np.testing.assert_allclose(size_of(thing.kind.make(thing.seed, thing.size_m)), (0.5, 0.6, 0.7), rtol=1e-5)


def test_without_a_ceiling_there_is_the_sky(path: Path) -> None:
    assert load_world(write(path)).ceiling_m is None


def test_a_path_may_be_a_string(path: Path) -> None:
    assert load_world(str(write(path))).name == "small"


def test_objects_without_a_name_are_counted_by_kind(path: Path) -> None:
    far = [{"pose": "[2, -1, 0]"}, {"pose": "[4, -1, 0]", "kind": "'barrel'"}, {"pose": "[3, -1, 0]"}]
    assert [thing.name for thing in load_world(write(path, *far)).things] == ["crate 1", "barrel 1", "crate 2"]


def test_seeds_follow_from_the_worlds_and_the_place_in_the_file_unless_given(path: Path) -> None:
    two = [{"pose": "[2, -1, 0]"}, {"pose": "[4, -1, 0]"}]
    first, second = (thing.seed for thing in load_world(write(path, *two)).things)
    assert first != second
    assert [thing.seed for thing in load_world(write(path, *two)).things] == [first, second]
    assert [thing.seed for thing in load_world(write(path, two[0], {**two[1], "seed": "5"})).things] == [first, 5]
    assert [thing.seed for thing in load_world(write(path, *two, seed="8")).things] != [first, second]


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ({"version": "2"}, r"Invalid enum value 2 - at `\$.version`"),
        ({"lights": "3"}, "unknown field `lights`"),
        ({"seed": "-1"}, r"Expected `int` >= 0 - at `\$.seed`"),
        ({"seed": "0.5"}, r"Expected `int`, got `float` - at `\$.seed`"),
        ({"ceiling_m": "inf"}, r"Expected `float` <= 30.0 - at `\$.ceiling_m`"),
        ({"start": "[0, 0]"}, r"Expected `array` of length 3, got 2 - at `\$.start`"),
        ({"start": "[nan, 0, 0]"}, r"at `\$.start\[0\]`"),
        ({"goal": "[4, 0, 900]"}, r"Expected `float` <= 360.0 - at `\$.goal\[2\]`"),
        ({"goal": "[4, 1000, 0]"}, r"Expected `float` <= 100.0 - at `\$.goal\[1\]`"),
        ({"floor": "'lava'"}, "floor: expected one of asphalt, carpet, concrete, .*, got 'lava'$"),
    ],
)
def test_a_bad_head_is_refused_by_its_key(path: Path, head: dict[str, str], message: str) -> None:
    assert_refused(write(path, **head), message)


def test_a_missing_key_is_named(path: Path) -> None:
    path.write_text(table({key: value for key, value in HEAD.items() if key != "goal"}), encoding="utf-8")
    assert_refused(path, "missing required field `goal`")


@pytest.mark.parametrize(
    ("wall", "message"),
    [
        ({"points": "[[0, 9]]"}, r"length >= 2 - at `\$.walls\[0\].points`"),
        (
            {"points": "[[0, 9], [1, 9], [1, 9]]"},
            r"walls\[0\].points: expected neighbours that differ, got \[1.0, 9.0]",
        ),
        ({"thickness_m": "0"}, r"at `\$.walls\[0\].thickness_m`"),
        ({"height_m": "31"}, r"at `\$.walls\[0\].height_m`"),
        ({"finish": "'gold'"}, r"walls\[0\].finish: expected one of brick, .*, got 'gold'$"),
        ({"color": "'red'"}, r"unknown field `color` - at `\$.walls\[0\]`"),
    ],
)
def test_a_bad_wall_is_refused_by_its_key(path: Path, wall: dict[str, str], message: str) -> None:
    assert_refused(write(path, wall=wall), message)


@pytest.mark.parametrize(
    ("thing", "message"),
    [
        ({"kind": "'unicorn'"}, r"objects\[0\].kind: expected one of .*barrel, .*oscilloscope.*, got 'unicorn'$"),
        ({"size": "[0.5, 0.6]"}, r"length 3, got 2 - at `\$.objects\[0\].size`"),
        ({"size": "[0.5, 0.6, 0]"}, r"at `\$.objects\[0\].size\[2\]`"),
        ({"name": "''"}, r"at `\$.objects\[0\].name`"),
        ({"seed": "-3"}, r"at `\$.objects\[0\].seed`"),
        ({"label": "'car'"}, r"unknown field `label` - at `\$.objects\[0\]`"),
    ],
)
def test_a_bad_object_is_refused_by_its_key(path: Path, thing: dict[str, str], message: str) -> None:
    assert_refused(write(path, thing), message)


def test_two_objects_of_one_name_are_refused(path: Path) -> None:
    two = [{"name": "'box'"}, {"name": "'box'", "pose": "[4, -1, 0]"}]
    assert_refused(write(path, *two), "objects: expected every name once, got 'box' twice")


def test_objects_that_stand_in_each_other_are_refused_with_both_names(path: Path) -> None:
    two = [{"name": "'box'"}, {"pose": "[2.4, -1, 0]", "name": "'chest'"}]
    assert_refused(write(path, *two), "objects: expected box and chest apart, got 100 mm of one inside the other$")


def test_an_object_that_stands_in_a_wall_is_refused_with_both_names(path: Path) -> None:
    message = r"objects: expected crate 1 and the wall from \(-1, -2\) to \(6, -2\) apart, got \d+ mm"
    assert_refused(write(path, {"pose": "[2, -1.7, 0]"}), message)


def test_objects_may_touch_each_other(path: Path) -> None:
    two = [{"pose": "[2, -1, 0]"}, {"pose": "[2.5, -1, 0]"}]
    assert len(load_world(write(path, *two)).things) == 2


def test_turned_objects_are_apart_where_only_their_boxes_would_overlap(path: Path) -> None:
    two = [{"pose": "[2, -1, 45]"}, {"pose": "[2.5, -0.5, 45]"}]
    assert len(load_world(write(path, *two)).things) == 2


@pytest.mark.parametrize(
    ("head", "pose", "message"),
    [
        ({}, "[0.5, 0, 0]", r"start: expected 0.3 m free on all sides, got 0.25 m to crate 1$"),
        ({}, "[0, 0, 0]", r"start: expected 0.3 m free on all sides, got 0.00 m to crate 1$"),
        ({}, "[4.5, 0, 0]", r"goal: expected 0.3 m free on all sides, got 0.25 m to crate 1$"),
        ({"goal": "[5.8, 1, 0]"}, "[2, 2, 0]", r"goal: .* got 0.1\d m to the wall from \(6, -2\) to \(6, 3\)$"),
    ],
)
def test_what_the_robot_would_run_into_is_refused(path: Path, head: dict[str, str], pose: str, message: str) -> None:
    assert_refused(write(path, {"pose": pose}, **head), message)


def test_the_documentations_example_is_a_world(path: Path) -> None:
    text = (Path(__file__).parents[1] / "docs" / "simulation.md").read_text(encoding="utf-8")
    path.write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    assert [thing.name for thing in load_world(path).things] == ["car 1", "the old washer", "barrel 1"]


def test_a_name_that_does_not_ship_is_refused_with_those_that_do() -> None:
    with pytest.raises(
        RefusedError, match=f"^world: expected a .toml file or one of {', '.join(world_names())}, got 'x'$"
    ):
        load_world("x")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=f"^{re.escape(str(tmp_path / 'none.toml'))}: cannot be read"):
        load_world(tmp_path / "none.toml")


def box(x: float, y: float, depth: float, width: float, theta: float) -> np.ndarray:
    c, s = math.cos(theta), math.sin(theta)
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (depth / 2, width / 2)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


BOXES = st.builds(box, *[st.floats(-2, 2)] * 2, *[st.floats(0.05, 2)] * 2, st.floats(-math.pi, math.pi))


@settings(max_examples=40)
@given(BOXES, BOXES)
def test_the_distance_between_outlines_is_that_of_their_nearest_points(a: np.ndarray, b: np.ndarray) -> None:
    steps = np.linspace(0, 1, 60)[:, None]
    on_a, on_b = (np.concatenate([p + steps * (q - p) for p, q in zip(o, np.roll(o, -1, axis=0))]) for o in (a, b))
    nearest = np.hypot(*(on_a[:, None] - on_b).reshape(-1, 2).T).min()
    assert apart_m(a, b) == pytest.approx(apart_m(b, a), abs=1e-9)
    assert apart_m(a, b) <= nearest + 1e-9
    if apart_m(a, b) > 0:
        assert apart_m(a, b) == pytest.approx(nearest, abs=0.04)


@settings(max_examples=40)
@given(BOXES, BOXES)
def test_outlines_that_are_moved_apart_by_their_depth_no_longer_overlap(a: np.ndarray, b: np.ndarray) -> None:
    depth_m = -apart_m(a, b)
    if depth_m > 0:
        turns = np.linspace(0, 2 * np.pi, 181)
        moved = [apart_m(a, b + (1.01 * depth_m + 0.001) * np.array((np.cos(t), np.sin(t)))) for t in turns]
        assert max(moved) > 0
        assert all(apart_m(a, b + 0.95 * depth_m * np.array((np.cos(t), np.sin(t)))) < 0 for t in turns[::12])
