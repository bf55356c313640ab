# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""BARN worlds: the score's known answers, which files are refused, and under which conditions is driven."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import barn
from benchmarks.barn_setups import VARIANTS, setups
from benchmarks.barn_table import HEADER, cells, row
from benchmarks.barn_worlds import SIDES, goal_in_odom, read_worlds, score

from edgefusion.errors import RefusedError

INDEX = {
    "radius": 0.075,
    "start": [1.0, 2.0, math.pi / 2],
    "goal": [1.0, 6.0],
    "goal_tolerance": 1.0,
    "timeout": 20.0,
    "footprint": [[-0.21, -0.165], [-0.21, 0.165], [0.21, 0.165], [0.21, -0.165]],
    "worlds": [{"world": 4, "path_length": 4.0}, {"world": 7, "path_length": 5.0}],
}
CENTRES = {"centres_4": np.array([[3.0, 4.0]], np.float32), "centres_7": np.array([[1.0, 3.0], [-1.0, 4.0]])}


@pytest.fixture
def files(tmp_path):
    """Writes a pair of files, changed as a test wants it: (worlds, index)."""

    def write(index=INDEX, centres=CENTRES):
        paths = tmp_path / "worlds.npz", tmp_path / "index.json"
        np.savez(paths[0], **centres)
        paths[1].write_text(index if isinstance(index, str) else json.dumps(index), encoding="utf-8")
        return paths

    return write


@pytest.mark.parametrize(
    ("time_s", "expected"),
    [(2.0, 0.5), (10.0, 0.5), (20.0, 0.25), (40.0, 0.125), (90.0, 0.125)],  # the way of 10 m takes 5 s at 2 m/s
)
def test_the_score_of_a_success_is_the_optimal_time_over_the_clipped_one(time_s, expected):
    assert score(True, 10.0, time_s) == pytest.approx(expected)


def test_a_failure_scores_nothing():
    assert score(False, 10.0, 5.0) == 0


def test_worlds_are_read_in_the_indexs_order_with_their_cylinders(files):
    index, worlds = read_worlds(*files())
    assert [(world.number, world.path_length_m, len(world.centres_m)) for world in worlds] == [(4, 4.0, 1), (7, 5.0, 2)]
    assert (index.goal_tolerance, index.timeout) == (1.0, 20.0)


def test_the_goal_is_ahead_of_the_start_where_odometry_begins(files):
    goal = goal_in_odom(read_worlds(*files())[0])
    assert (goal.x_m, goal.y_m, goal.theta) == pytest.approx((4.0, 0.0, 0.0))


def test_a_cylinder_is_a_closed_polygon_that_touches_it_from_outside(files):
    segments = read_worlds(*files())[1][0].segments(0.075) - [3, 4, 3, 4]
    corners, middles = segments[:, :2], (segments[:, :2] + segments[:, 2:]) / 2
    assert len(segments) == SIDES
    np.testing.assert_allclose(segments[:, 2:], np.roll(corners, -1, axis=0))
    np.testing.assert_allclose(np.hypot(*middles.T), 0.075)
    assert (np.hypot(*corners.T) < 0.075 * 1.036).all()


@pytest.mark.parametrize(
    ("index", "centres", "said"),
    [
        ("{", CENTRES, "truncated"),
        ({**INDEX, "radius": 0}, CENTRES, "radius: expected more than 0"),
        ({key: INDEX[key] for key in INDEX if key != "footprint"}, CENTRES, "footprint"),
        ({**INDEX, "worlds": []}, CENTRES, "at least one"),
        (INDEX, {"centres_4": CENTRES["centres_4"]}, "expected an array centres_7, got 1 others"),
        (INDEX, {**CENTRES, "centres_7": np.zeros((3, 3))}, r"expected numbers \[n, 2\], got float64 \[3, 3\]"),
        (INDEX, {**CENTRES, "centres_7": np.array([["a", "b"]])}, "expected numbers"),
        (INDEX, {**CENTRES, "centres_7": np.full((1, 2), np.nan)}, "expected finite numbers"),
    ],
)
def test_files_of_another_layout_are_refused(files, index, centres, said):
    with pytest.raises(RefusedError, match=said):
        read_worlds(*files(index, centres))


def test_what_is_no_npz_is_refused(files, tmp_path):
    index, plain, broken = files()[1], tmp_path / "plain.npy", tmp_path / "broken.npz"
    np.save(plain, np.zeros(3))
    broken.write_bytes(b"PK\x03\x04 and no more")
    for worlds in (plain, broken, index, tmp_path / "absent.npz"):
        with pytest.raises(RefusedError, match=worlds.name):
            read_worlds(worlds, index)


def test_the_command_refuses_in_one_line(files, capsys):
    worlds, index = files(centres={"centres_4": CENTRES["centres_4"]})
    with pytest.raises(SystemExit) as refused:
        barn.main(["--worlds", str(worlds), "--index", str(index)])
    assert refused.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    ("index", "options", "said"),
    [
        (INDEX, ["--only", "4", "9999", "-1"], "--only: expected numbers of worlds in the index, got -1, 9999"),
        (INDEX, ["--speeds", "0"], "max_speed_mps: "),
        (INDEX, ["--speeds", "1", "nan"], "max_speed_mps: "),
        (INDEX, ["--speeds", "11"], "max_speed_mps: "),
        (INDEX, ["--speeds", "--variants"], "--fields, --speeds, --variants: expected something to drive, got none"),
        ({**INDEX, "footprint": [[0, 0], [1, 0], [1, 1]]}, [], "footprint_m: "),
        ({**INDEX, "footprint": [[0, 0], [1, 0]]}, [], ""),
    ],
)
def test_what_cannot_be_driven_is_refused_in_one_line_before_anything_is(files, tmp_path, capsys, index, options, said):
    paths = files(index)
    with pytest.raises(SystemExit) as refused:
        barn.main(["--worlds", str(paths[0]), "--index", str(paths[1]), "--out", str(tmp_path / "out"), *options])
    assert refused.value.code == 2
    out, err = capsys.readouterr()
    assert err.startswith(f"python -m benchmarks.barn: {said}") and err.count("\n") == 1
    assert not out and not (tmp_path / "out").exists()


def test_the_setups_are_those_that_the_table_promises(files):
    table = setups(read_worlds(*files())[0], ["navigation-function", "khatib"], [1.0, 2.0], VARIANTS)
    assert [(each.field, each.variant, each.base.max_speed_mps) for each in table] == [
        ("navigation-function", "-", 1.0),
        ("navigation-function", "-", 2.0),
        ("khatib", "-", 1.0),
        ("khatib", "-", 2.0),
        ("navigation-function", "P3-DX", 1.0),
        ("navigation-function", "odometry 2 % short", 1.0),
        ("navigation-function", "commands 0.2 s late", 1.0),
    ]
    assert [each.spec.command_delay_ns for each in table] == [0, 0, 0, 0, 0, 0, 200_000_000]
    assert [each.spec.base.left_drift_percent for each in table] == [0, 0, 0, 0, 0, 2, 0]
    assert [each.spec.laser.beams for each in table] == [541] * 4 + [361] + [541] * 2
    for each in table:
        assert each.spec.base.acceleration_mps2 == each.base.acceleration_mps2
        assert each.spec.laser.sigma_m == 0.01
        assert each.spec.laser.dropped == 0


def test_a_row_says_the_conditions_and_counts_every_run_once(files):
    setup = setups(read_worlds(*files())[0], ["khatib"], [2.0], [])[0]
    runs = [
        {"outcome": outcome, "time_s": time_s, "clearance_m": 0.1, "score": points}
        for outcome, time_s, points in (
            ("reached", 10.0, 0.5), ("reached", 20.0, 0.3), ("contact", 3.0, 0.0), ("blocked", 5.0, 0.0),
            ("timeout", 100.0, 0.0),
        )
    ]  # fmt: skip
    found = row(setup.field, setup.variant, setup.base, setup.spec, runs)
    assert (found["success"], found["collision"], found["stuck"]) == pytest.approx((0.4, 0.2, 0.4))
    assert (found["time_mean_s"], found["score"]) == pytest.approx((15.0, 0.16))
    text = dict(zip(HEADER, cells(found)))
    assert text["speed"] == "2.0 m/s"
    assert text["turning"] == "3 rad/s"
    assert text["accelerations"] == "4 m/s^2, 12 rad/s^2"
    assert text["beams"] == "541 over 270 deg"


def test_two_worlds_are_driven_and_written_down(files, tmp_path, capsys):
    worlds, index = files()
    options = ["--fields", "navigation-function", "--speeds", "1.0", "--variants", "--out", str(tmp_path)]
    assert barn.main(["--worlds", str(worlds), "--index", str(index), *options]) == 0
    table = capsys.readouterr().out
    assert "100.0 %" in table
    assert "goal within 1 m, 20 s at most, seed 0" in table
    (details,) = json.loads((tmp_path / "barn_worlds.json").read_text(encoding="utf-8"))
    assert [run["world"] for run in details["runs"]] == [4, 7]
    assert all(3.0 < run["time_s"] < 10.0 for run in details["runs"])
    assert (tmp_path / "barn.md").is_file()
