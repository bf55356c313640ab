# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A Pioneer's pose: through wraps, resets and lost SIPs, and untouched by noise that passed the checksum."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.config import PioneerConfig
from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE, Factors, factors_for
from edgefusion.drivers.pioneer_odometry import NEW_COUNTS, Odometry
from edgefusion.drivers.sip_status import Status, read_status
from edgefusion.types import Pose2D, Twist2D
from sip_traces import sip_body

CYCLE_NS = 100_000_000
SH = factors_for("p3dx-sh", PioneerConfig())
H8 = factors_for("P3DX", PioneerConfig())
STARTS = st.tuples(st.integers(0, 0x7FFF), st.integers(0, 0x7FFF), st.integers(-2048, 2047))
SPEEDS = st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.5, 1.5)), min_size=1, max_size=20)


def status(factors: Factors, start: tuple[int, int, int], pose: Pose2D, twist: Twist2D) -> Status:
    """What a robot says that began with these counts and has come to a pose."""
    x0, y0, heading0 = start
    c, s = (f(heading0 * factors.heading) for f in (math.cos, math.sin))
    x = round((c * pose.x_m - s * pose.y_m) / factors.distance_m) + x0
    y = round((s * pose.x_m + c * pose.y_m) / factors.distance_m) + y0
    heading = (round(pose.theta / factors.heading) + heading0 + 2048) % 4096 - 2048
    aside = twist.w_radps / HALF_WHEEL_BASE
    left, right = (round(twist.v_mps * 1e3 + side * aside) for side in (-1, 1))
    return read_status(sip_body(x=x & 0x7FFF, y=y & 0x7FFF, heading=heading, left=left, right=right))


def drive(speeds: list[tuple[float, float]], cycles: int = 10) -> Iterator[tuple[int, Pose2D, Twist2D]]:
    """Stamps, poses and velocities of a robot that takes up one speed after the other as fast as it can."""
    pose, v, w = Pose2D(), 0.0, 0.0
    for cycle in range(len(speeds) * cycles):
        yield cycle * CYCLE_NS, pose, Twist2D(v, w)
        v += max(-0.2, min(0.2, speeds[cycle // cycles][0] - v))
        w += max(-0.5, min(0.5, speeds[cycle // cycles][1] - w))
        pose = pose.compose(Twist2D(v, w).motion(CYCLE_NS / 1e9))


@pytest.mark.parametrize("factors", [SH, H8])
@given(start=STARTS, speeds=SPEEDS)
def test_the_pose_is_where_the_robot_went_whatever_its_counts_began_at(factors, start, speeds) -> None:
    odometry = Odometry(factors)
    for stamp_ns, pose, twist in drive(speeds):
        assert odometry.add(stamp_ns, status(factors, start, pose, twist))
        assert math.dist((odometry.pose.x_m, odometry.pose.y_m), (pose.x_m, pose.y_m)) < 0.005
        assert abs(math.remainder(odometry.pose.theta - pose.theta, 2 * math.pi)) < 0.002


@given(speeds=SPEEDS, seed=st.integers(0, 2**32))
def test_lost_and_late_sips_change_nothing_of_where_it_gets_to(speeds, seed) -> None:
    chance, odometry, stamps = random.Random(seed), Odometry(SH), [0]
    for stamp_ns, pose, twist in drive(speeds):
        if stamp_ns and chance.random() < 0.3:
            continue
        stamps.append(max(stamps[-1] + 1, stamp_ns + chance.randrange(CYCLE_NS)))
        assert odometry.add(stamps[-1], status(SH, (0, 0, 0), pose, twist))
        assert math.dist((odometry.pose.x_m, odometry.pose.y_m), (pose.x_m, pose.y_m)) < 0.005


@pytest.mark.parametrize(
    "lie",
    [
        {"x_counts": 300},
        {"y_counts": 0x7FFF - 300},
        {"heading_counts": 1024},
        {"left_speed": 2500, "right_speed": 2500},
        {"left_speed": -600, "right_speed": 600},
        {"left_speed": -700, "right_speed": -700},
    ],
)
def test_a_sip_that_no_robot_could_send_then_is_left_out(lie: dict[str, int]) -> None:
    odometry = Odometry(SH)
    before = [(stamp_ns, status(SH, (0, 0, 0), pose, twist)) for stamp_ns, pose, twist in drive([(0.0, 0.0)])]
    for stamp_ns, each in before:
        odometry.add(stamp_ns, each)
    assert not odometry.add(before[-1][0] + CYCLE_NS, replace(before[-1][1], **lie))
    assert odometry.pose == Pose2D()
    assert odometry.add(before[-1][0] + 2 * CYCLE_NS, before[-1][1])


def test_a_robot_that_stops_at_a_wall_is_believed() -> None:
    odometry = Odometry(SH)
    assert odometry.add(0, read_status(sip_body(left=800, right=800)))
    assert odometry.add(CYCLE_NS, read_status(sip_body(x=20)))


def test_counts_that_begin_anew_leave_the_pose_where_it_is() -> None:
    odometry = Odometry(SH)
    for stamp_ns, pose, twist in drive([(0.5, 0.0)] * 3):
        odometry.add(stamp_ns, status(SH, (0, 0, 0), pose, twist))
    where = odometry.pose
    believed = [odometry.add(stamp_ns + i * CYCLE_NS, read_status(sip_body())) for i in range(1, 6)]
    assert believed == [False] * NEW_COUNTS + [True] * (5 - NEW_COUNTS)
    assert odometry.pose == where


def test_a_lie_that_could_be_true_is_forgotten_when_what_comes_later_belies_it() -> None:
    odometry = Odometry(SH)
    odometry.add(0, read_status(sip_body(left=300, right=300)))
    assert odometry.add(5 * CYCLE_NS, read_status(sip_body(x=250, y=250, left=300, right=300)))
    for i in range(1, NEW_COUNTS + 1):
        odometry.add((5 + i) * CYCLE_NS, read_status(sip_body(x=150 + 30 * i, left=300, right=300)))
    x_m = (150 + 30 * NEW_COUNTS) / 1e3
    assert odometry.pose == Pose2D(x_m, 0.0)
    assert odometry.add((6 + NEW_COUNTS) * CYCLE_NS, read_status(sip_body(x=270, left=300, right=300)))
    assert odometry.pose.x_m == pytest.approx(0.27)


@given(theta=st.floats(-3.1, 3.1), own=st.integers(-2047, 2047))
def test_a_heading_is_turned_into_the_robots_own(theta: float, own: int) -> None:
    odometry = Odometry(SH, Pose2D(1.0, 2.0, theta))
    odometry.add(0, read_status(sip_body(heading=own)))
    ahead = odometry.robot_heading(theta + 0.5) - own * SH.heading
    assert math.remainder(ahead, 2 * math.pi) == pytest.approx(0.5)


def test_factors_go_by_the_board_and_the_configuration() -> None:
    assert (H8.distance_m, SH.distance_m) == pytest.approx((0.000485, 0.001))
    own = factors_for("p3dx", PioneerConfig(distance_factor_mm=0.58, heading_factor=0.0018, range_factor_mm=0.268))
    assert (own.distance_m, own.heading, own.range_m) == pytest.approx((0.00058, 0.0018, 0.000268))
