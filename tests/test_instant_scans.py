# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Scans for the bus: a robot that turns sees straight walls in them, and none comes of what nobody knows."""

from __future__ import annotations

import math

import numpy as np

from base_scenes import CONFIG, Bench, S
from edgefusion.service.instant_scans import CARRIED_NS, InstantScans
from edgefusion.types import Goal, Pose2D, Scan

T_BASE_LASER = Pose2D(*CONFIG.base.laser_pose).matrix()


def turning() -> Bench:
    """A second and a half of turning on the spot."""
    bench = Bench()
    bench.run(1)
    bench.loop.goto([Goal("turn", Pose2D(0, 0, math.pi))])
    bench.run(1.5)
    return bench


def told(bench: Bench) -> list[Scan]:
    """Of the last second."""
    scans, found = InstantScans(T_BASE_LASER), []
    for output in bench.outputs:
        if output.robot is not None:
            scans.reported(output.robot)
        if output.scan is not None and output.stamp_ns > 1.5 * S:
            found.append(scans.of(output.scan))
    return found


def wall_error_m(scan, bench: Bench) -> float:
    """How far its points lie off the room's walls, for all but a few of them."""
    pose = bench.truth.at(scan.stamp_ns).compose(Pose2D(*CONFIG.base.laser_pose))
    hit = np.isfinite(scan.ranges_m)
    angles = scan.angles[hit] + pose.theta
    x, y = pose.x_m + scan.ranges_m[hit] * np.cos(angles), pose.y_m + scan.ranges_m[hit] * np.sin(angles)
    off = np.min([np.abs(x + 2), np.abs(x - 4), np.abs(y + 2), np.abs(y - 2)], axis=0)
    return float(np.quantile(off, 0.95))


def test_scans_of_a_robot_that_turns_are_as_if_of_one_instant() -> None:
    bench = turning()
    scans = told(bench)
    assert len(scans) >= 15
    assert all(scan.beam_dt_ns is None and wall_error_m(scan, bench) < 0.03 for scan in scans)


def test_without_news_of_the_robot_there_is_none() -> None:
    bench = turning()
    scan = bench.outputs[-1].scan
    state = next(output.robot for output in bench.outputs if output.robot is not None)
    scans = InstantScans(T_BASE_LASER)
    assert scans.of(scan) is None
    scans.reported(state)
    assert scan.stamp_ns - state.stamp_ns > CARRIED_NS
    assert scans.of(scan) is None
