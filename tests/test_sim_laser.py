# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated LMS2xx: its noise, its dropped beams, its mixed pixels and its two mirror turns are what they say."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.types import Pose2D, Twist2D

SPEC = LaserSpec()
EXACT = replace(SPEC, sigma_m=0.0, dropped=0.0, mixed=0.0)
STAMP_NS = 5_000_000_000
ROOM = np.array([[-1, -4, 5, -4], [5, -4, 5, 4], [5, 4, -1, 4], [-1, 4, -1, -4]], float)


def post(x: float, y: float, side: float) -> np.ndarray:
    """A square pillar about (x, y)."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2 + (x, y)
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


POSTS = np.vstack([ROOM, *(post(2 * math.cos(a), 2 * math.sin(a), 0.2) for a in np.radians(range(-80, 81, 20)))])


def stand(pose: Pose2D | None = None) -> Callable[[int], Pose2D]:
    return lambda stamp_ns: pose or Pose2D()


def drive(twist: Twist2D) -> Callable[[int], Pose2D]:
    return lambda stamp_ns: twist.motion((stamp_ns - STAMP_NS) / 1e9)


def ranges_of(spec: LaserSpec, walls: np.ndarray, pose_at=None, seed: int = 0) -> np.ndarray:
    scan, _ = SimLaser(spec).scan(STAMP_NS, walls, pose_at or stand(), np.random.default_rng(seed))
    return scan.ranges_m.astype(float)


def many_ranges(spec: LaserSpec, walls: np.ndarray, scans: int) -> np.ndarray:
    laser, rng = SimLaser(spec), np.random.default_rng(3)
    return np.array([laser.scan(STAMP_NS, walls, stand(), rng)[0].ranges_m for _ in range(scans)], float)


def test_ranges_spread_by_sigma_about_the_truth() -> None:
    truth = ranges_of(EXACT, ROOM)
    errors = many_ranges(replace(SPEC, dropped=0.0), ROOM, 60) - truth
    assert abs(errors.mean()) < 3e-4
    assert errors.std() == pytest.approx(SPEC.sigma_m, rel=0.03)


def test_the_true_ranges_are_geometrys() -> None:
    middle = slice(150, 211)
    angles = np.radians(np.linspace(-90, 90, 361))[middle]
    np.testing.assert_allclose(ranges_of(EXACT, ROOM)[middle], 5 / np.cos(angles), atol=5.1e-4)


def test_ranges_are_whole_millimetres() -> None:
    millimetres = many_ranges(SPEC, POSTS, 5) * 1000
    millimetres = millimetres[np.isfinite(millimetres)]
    np.testing.assert_allclose(millimetres, np.round(millimetres), atol=1e-3)


@pytest.mark.parametrize("dropped", [0.0, 0.01, 0.3, 1.0])
def test_so_many_beams_are_dropped(dropped: float) -> None:
    ranges = many_ranges(replace(SPEC, dropped=dropped), ROOM, 60)
    assert np.isnan(ranges).mean() == pytest.approx(dropped, abs=0.02 if 0 < dropped < 1 else 0)


@pytest.mark.parametrize("mixed", [0.0, 0.5, 1.0])
def test_so_many_edges_are_mixed_and_read_between_the_two_surfaces(mixed: float) -> None:
    truth = ranges_of(EXACT, POSTS)
    # The posts are far from each other and from the walls: 9 posts have 18 edges, and no beam belongs to two.
    left = np.flatnonzero(np.abs(np.diff(truth)) > 1)
    assert len(left) == 18
    ranges = many_ranges(replace(EXACT, mixed=mixed), POSTS, 200)
    near, far = np.minimum(truth[left], truth[left + 1]), np.maximum(truth[left], truth[left + 1])
    changed = np.abs(ranges - truth) > 1e-3
    pairs = np.stack([changed[:, left], changed[:, left + 1]])
    assert not pairs.all(axis=0).any()
    assert pairs.any(axis=0).mean() == pytest.approx(mixed, abs=0.03 if 0 < mixed < 1 else 0.005)
    assert pairs[0].mean() == pytest.approx(mixed / 2, abs=0.03)
    read = np.where(pairs[0], ranges[:, left], ranges[:, left + 1])[pairs.any(axis=0)]
    at = np.broadcast_to(np.arange(18), pairs[0].shape)[pairs.any(axis=0)]
    assert ((read >= near[at] - 1e-3) & (read <= far[at] + 1e-3)).all()
    changed[:, left] = changed[:, left + 1] = False
    assert not changed.any()


@pytest.mark.parametrize(
    "walls",
    [
        np.array([[-3, 0.2, 0.5, 0.2], [0.5, 0.2, 2, 0.2], [2, 0.2, 8, 0.2]]),  # a slanted wall of several segments
        np.array([[1, -3, 1, 0.1], [1, 0.1, 2, 0.3]]),  # round a corner onto a face that is seen at a grazing angle
    ],
)
def test_a_surface_that_is_only_slanted_has_no_edges(walls: np.ndarray) -> None:
    truth = ranges_of(EXACT, walls)
    assert np.nanmax(np.abs(np.diff(truth[np.isfinite(truth)]))) > SPEC.edge_m
    np.testing.assert_array_equal(ranges_of(replace(EXACT, mixed=1.0), walls), truth)


def test_a_beam_that_meets_nothing_reads_infinity_and_mixes_with_nobody() -> None:
    walls = post(2, 0, 0.5)
    scan, hits = SimLaser(replace(EXACT, mixed=1.0)).scan(STAMP_NS, walls, stand(), np.random.default_rng(0))
    assert np.isposinf(scan.ranges_m[hits < 0]).all()
    np.testing.assert_array_equal(scan.ranges_m, ranges_of(EXACT, walls).astype(np.float32))
    assert set(hits) == {-1, 3}


def test_from_the_wires_code_for_too_far_on_it_reads_infinity() -> None:
    for distance_m, expected in ((8.182, 8.182), (8.183, math.inf), (8.4, math.inf)):
        assert ranges_of(EXACT, np.array([[distance_m, -1, distance_m, 1]]))[180] == pytest.approx(expected)


def test_hits_are_the_true_rows_also_of_dropped_and_mixed_beams() -> None:
    _, truth = SimLaser(EXACT).scan(STAMP_NS, POSTS, stand(), np.random.default_rng(0))
    spoilt = replace(SPEC, mixed=1.0, dropped=0.5)
    _, hits = SimLaser(spoilt).scan(STAMP_NS, POSTS, stand(), np.random.default_rng(0))
    np.testing.assert_array_equal(hits, truth)
    assert hits.dtype == np.int32


@pytest.mark.parametrize("w_radps", [-0.5, 0.5])
def test_while_the_robot_turns_odd_beams_see_it_one_mirror_turn_later(w_radps: float) -> None:
    ranges = ranges_of(EXACT, np.array([[1, -9, 1, 9]]), drive(Twist2D(0.0, w_radps)))
    directions = np.arccos(1 / ranges[181:300])  # left of the middle, from the range to a wall 1 m ahead
    jump = directions - np.radians(0.5) * np.arange(1, 120)
    odd, even = jump[0:-1:2], jump[1::2]
    # Interpolated between the two neighbours of the other parity, so that the sweep itself cancels out.
    shift = odd[1:-1] - (even[:-2] + even[1:-1]) / 2
    assert np.median(shift) == pytest.approx(w_radps * SPEC.turn_ns / 1e9, rel=0.03)


def test_every_beam_is_where_its_own_time_says() -> None:
    twist = Twist2D(0.0, 0.5)
    scan, _ = SimLaser(EXACT).scan(STAMP_NS, ROOM, drive(twist), np.random.default_rng(0))
    for beam in (0, 1, 90, 180, 181, 275, 359, 360):
        pose = drive(twist)(STAMP_NS + int(scan.beam_dt_ns[beam]))
        assert scan.ranges_m[beam] == pytest.approx(ranges_of(EXACT, ROOM, stand(pose))[beam], abs=1.1e-3)


def test_the_middle_beam_is_measured_at_the_stamp_and_the_others_in_the_order_of_the_mirror() -> None:
    scan, _ = SimLaser(SPEC).scan(STAMP_NS, ROOM, stand(), np.random.default_rng(0))
    assert scan.stamp_ns == STAMP_NS
    assert scan.beam_dt_ns[180] == 0
    for parity in (0, 1):
        assert (np.diff(scan.beam_dt_ns[parity::2]) > 0).all()
    assert scan.beam_dt_ns[181] - scan.beam_dt_ns[180] == pytest.approx(SPEC.turn_ns * (1 + 0.5 / 360), abs=1)
    assert scan.beam_dt_ns[360] - scan.beam_dt_ns[0] == pytest.approx(SPEC.turn_ns / 2, abs=1)


def test_a_robot_that_stands_does_not_notice_the_interlacing() -> None:
    pose_at = stand(Pose2D(0.3, -0.2, 0.4))
    plain = ranges_of(replace(EXACT, interlaced=False), POSTS, pose_at)
    np.testing.assert_array_equal(ranges_of(EXACT, POSTS, pose_at), plain)


def test_the_same_seed_gives_the_same_bytes() -> None:
    once, again = (ranges_of(SPEC, POSTS, seed=8) for _ in range(2))
    assert once.tobytes() == again.tobytes()
    assert once.tobytes() != ranges_of(SPEC, POSTS, seed=9).tobytes()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"beams": 0}, "beams: expected at least 1, got 0"),
        ({"dropped": 1.1}, "dropped: expected a share from 0 to 1, got 1.1"),
        ({"mixed": math.nan}, "mixed: expected a share from 0 to 1, got nan"),
        ({"sigma_m": -0.1}, "sigma_m: expected a finite number of at least 0, got -0.1"),
        ({"edge_m": math.inf}, "edge_m: expected a finite number of at least 0, got inf"),
        ({"turn_ns": -1}, "turn_ns: expected a finite number of at least 0, got -1"),
    ],
)
def test_what_is_no_laser_is_refused_by_name(changed: dict, message: str) -> None:
    with pytest.raises(RefusedError, match=f"^{message}$"):
        replace(SPEC, **changed)
