# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A deskewed scan is what a laser that measures all beams at once would have seen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from edgefusion.drivers.lms2xx_deskew import deskewed
from edgefusion.errors import RefusedError
from edgefusion.pose_history import PoseHistory
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.types import Pose2D, Scan, Twist2D

STAMP_NS = 5_000_000_000
EXACT = LaserSpec(sigma_m=0.0, dropped=0.0, mixed=0.0)
AT_ONCE = replace(EXACT, turn_ns=0)
ROOM = np.array(
    [[-4, -3, 5, -3], [5, -3, 5, 4], [5, 4, -4, 4], [-4, 4, -4, -3], [2, 0.5, 2, 1], [2.5, -1, 3, -1.2]], float
)
LASER = Pose2D(0.1, 0.05, 0.0)
UPRIGHT = LASER.matrix()
UPSIDE_DOWN = UPRIGHT @ np.diag([1.0, -1.0, -1.0, 1.0])


def pose_at(twist: Twist2D, stamp_ns: int) -> Pose2D:
    return Pose2D(0.3, -0.2, 0.4).compose(twist.motion((stamp_ns - STAMP_NS) / 1e9))


def poses(twist: Twist2D) -> PoseHistory:
    history = PoseHistory()
    for ms in range(-100, 101, 10):
        stamp_ns = STAMP_NS + ms * 1_000_000
        history.add(stamp_ns, pose_at(twist, stamp_ns))
    return history


def scan_of(spec: LaserSpec, twist: Twist2D) -> Scan:
    laser, rng = SimLaser(spec), np.random.default_rng(0)
    return laser.scan(STAMP_NS, ROOM, lambda ns: pose_at(twist, ns).compose(LASER), rng)[0]


def errors_m(scan: Scan, truth: Scan) -> np.ndarray:
    """Of the beams, but those beside an edge, which may fall on its other side."""
    ranges, true = scan.ranges_m.astype(float), truth.ranges_m.astype(float)
    both = np.where(np.isfinite(true), true, 9.0)
    jumps = np.flatnonzero(np.abs(np.diff(both)) > 0.2)
    inner = np.ones(len(true), bool)
    for jump in jumps:
        inner[max(jump - 5, 0) : jump + 7] = False
    inner[:5] = inner[-5:] = False
    return np.abs(ranges - true)[inner & np.isfinite(true)]


@pytest.mark.parametrize("v_mps", [0.0, 0.5])
@pytest.mark.parametrize("degrees_per_s", [-100, -40, 40, 100])
def test_the_robots_way_is_undone(v_mps: float, degrees_per_s: float) -> None:
    twist = Twist2D(v_mps, math.radians(degrees_per_s))
    skewed, truth = scan_of(EXACT, twist), scan_of(AT_ONCE, twist)
    before, after = errors_m(skewed, truth), errors_m(deskewed(skewed, poses(twist), UPRIGHT), truth)
    assert len(after) > 250
    assert np.quantile(after, 0.99) < 0.01
    assert np.sqrt(np.mean(after**2)) < 0.2 * np.sqrt(np.mean(before**2))


def test_a_robot_that_stands_changes_nothing_but_the_times() -> None:
    scan = scan_of(replace(EXACT, dropped=0.1), Twist2D())
    still = deskewed(scan, poses(Twist2D()), UPRIGHT)
    np.testing.assert_allclose(still.ranges_m, scan.ranges_m, rtol=1e-5)
    assert still.beam_dt_ns is None
    assert (still.stamp_ns, still.angle_min, still.range_max_m) == (scan.stamp_ns, scan.angle_min, scan.range_max_m)


def test_a_laser_upside_down_sees_the_turn_the_other_way() -> None:
    twist = Twist2D(0.0, math.radians(100))
    skewed, truth = scan_of(EXACT, twist), scan_of(AT_ONCE, twist)
    assert skewed.beam_dt_ns is not None
    flipped = replace(skewed, ranges_m=skewed.ranges_m[::-1], beam_dt_ns=skewed.beam_dt_ns[::-1])
    level = deskewed(flipped, poses(twist), UPSIDE_DOWN)
    assert np.quantile(errors_m(replace(level, ranges_m=level.ranges_m[::-1]), truth), 0.99) < 0.01


def test_free_and_unknown_directions_turn_with_the_robot() -> None:
    twist = Twist2D(0.0, math.radians(90))
    scan = scan_of(EXACT, twist)
    ranges = np.full(361, np.inf, np.float32)
    ranges[100:140] = np.nan
    beam_dt_ns = np.full(361, 20_000_000)
    moved = deskewed(replace(scan, ranges_m=ranges, beam_dt_ns=beam_dt_ns), poses(twist), UPRIGHT)
    unknown = np.flatnonzero(np.isnan(moved.ranges_m))
    # 90 deg/s x 20 ms = 1.8 degrees = 3.6 beams to the left; to the right of the first beam nobody looked.
    assert set(range(105, 143)) <= set(unknown) <= {*range(4), *range(103, 145)}
    assert {0, 1} <= set(unknown)
    assert np.isposinf(moved.ranges_m[200:]).all()


def test_a_scan_without_times_stays_as_it_is() -> None:
    scan = replace(scan_of(EXACT, Twist2D()), beam_dt_ns=None)
    assert deskewed(scan, PoseHistory(), UPRIGHT).ranges_m.tobytes() == scan.ranges_m.tobytes()


@pytest.mark.parametrize("beams", [0, 1, 2])
def test_scans_of_hardly_any_beams_are_deskewed_too(beams: int) -> None:
    scan = Scan(STAMP_NS, np.full(beams, 2.0), 0.0, 0.01, beam_dt_ns=np.arange(beams))
    np.testing.assert_allclose(deskewed(scan, poses(Twist2D()), UPRIGHT).ranges_m, np.full(beams, 2.0))


def test_poses_that_do_not_cover_the_sweep_are_refused() -> None:
    history = PoseHistory()
    history.add(STAMP_NS, Pose2D())
    with pytest.raises(RefusedError, match="the poses cover"):
        deskewed(scan_of(EXACT, Twist2D()), history, UPRIGHT)
