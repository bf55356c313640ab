# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A Pioneer's report in metres and words, and its sonar ring."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest

from edgefusion.config import PioneerConfig
from edgefusion.drivers.pioneer_factors import factors_for
from edgefusion.drivers.pioneer_sonar import KEPT_NS, RING, SonarRing
from edgefusion.drivers.pioneer_state import RobotState, robot_state
from edgefusion.drivers.sip_status import read_status
from edgefusion.types import Pose2D
from sip_traces import sip_body

SH = factors_for("p3dx-sh", PioneerConfig())
DOCUMENTED = (  # x, y [mm] and direction [degrees] of each sonar
    *((69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10)),
    *((166, -27, -10), (148, -78, -30), (114, -119, -50), (69, -136, -90)),
    *((-157, -136, -90), (-203, -119, -130), (-237, -78, -150), (-255, -27, -170)),
    *((-255, 27, 170), (-237, 78, 150), (-203, 119, 130), (-157, 136, 90)),
)


def state(stamp_ns: int = 0, **fields: object) -> RobotState:
    return robot_state(read_status(sip_body(**fields)), SH, Pose2D(1.0, 2.0, 3.0), stamp_ns)


def test_a_report_is_in_metres_and_words() -> None:
    report = state(5, left=200, right=300, front=0b101, rear=0b100000, flags=0x21, sonars=[(3, 1500), (9, 5000)])
    assert (report.stamp_ns, report.odometry) == (5, Pose2D(1.0, 2.0, 3.0))
    assert report.twist.v_mps == pytest.approx(0.25)
    assert report.twist.w_radps == pytest.approx(0.28)
    assert report.battery_v == 12.0
    assert (report.motors_enabled, report.e_stop_pressed) == (True, True)
    assert (report.stalled_left, report.stalled_right, report.stalled) == (False, True, True)
    assert report.front_bumpers == (False, True, False, False, False)
    assert report.rear_bumpers == (False, False, False, False, True)
    assert report.bumped
    assert report.sonar_m == {3: 1.5, 9: math.inf}


def test_what_a_report_leaves_out_is_unknown() -> None:
    report = state()
    assert (report.charging, report.digital_in, report.digital_out, report.temperature_c) == (None,) * 4
    tail = struct.pack("<5BHBhHhb", 0, 0, 0, 0xA5, 0x5A, 251, 3, -100, 0, 0, 41)
    report = state(tail=tail)
    assert report.battery_v == pytest.approx(25.1)
    assert report.twist.w_radps == pytest.approx(math.radians(-10))
    assert (report.charging, report.digital_in, report.digital_out, report.temperature_c) == (True, 0xA5, 0x5A, 41)
    report = state(tail=struct.pack("<5BHBhHhb", 0, 0, 0, 0, 0, 120, 255, 0, 0, 0, -128))
    assert (report.charging, report.temperature_c) == (None, None)


@pytest.mark.parametrize("number", range(16))
def test_every_sonar_is_where_the_documents_say(number: int) -> None:
    x_mm, y_mm, degrees = DOCUMENTED[number]
    assert RING[number] == pytest.approx((x_mm / 1e3, y_mm / 1e3, math.radians(degrees)))


def test_the_ring_keeps_what_each_sonar_heard_last_and_for_a_second() -> None:
    ring = SonarRing()
    ring.add(state(0, sonars=[(0, 1000), (1, 2000)]))
    ring.add(state(KEPT_NS // 2, sonars=[(1, 3000)]))
    assert ring.ranges_m(KEPT_NS // 2) == {0: 1.0, 1: 3.0}
    assert ring.ranges_m(KEPT_NS + 1) == {1: 3.0}


def test_the_points_behind_lie_on_the_axes_of_the_rear_sonars() -> None:
    ring = SonarRing()
    ring.add(state(0, sonars=[(3, 1000), (8, 500), (10, 5000), (15, 2000)]))
    assert ring.rear_points_m(0) == pytest.approx(np.array([[-0.157, -0.636], [-0.157, 2.136]]))
    assert SonarRing().rear_points_m(0).shape == (0, 2)
