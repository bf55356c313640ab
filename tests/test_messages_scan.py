# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Scans and clusters as messages and back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import WireError
from edgefusion.messages.from_clusters import from_clusters
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.geometry_msgs import Point
from edgefusion.messages.sensor_msgs import LaserScan
from edgefusion.messages.to_clusters import to_clusters
from edgefusion.messages.to_scan import to_scan
from edgefusion.messages.visualization_msgs import Marker, MarkerArray
from edgefusion.types import Cluster, Scan
from messages_scenes import STAMP_NS, STAMPER, sent, stamps_ns

NAN, INF = math.nan, math.inf
SCAN = Scan(STAMP_NS, np.array([1.0, 2.0, INF, -INF, NAN], np.float32), -0.5, 0.25, 0.1, 8.0)
OTHERS = LaserScan(
    STAMPER.header(STAMP_NS, "laser"), angle_increment=0.25, range_min=0.125, range_max=8.0, ranges=[1.0, 2.0, 3.0]
)


def refused(reason: str, **changes: object) -> None:
    with pytest.raises(WireError, match=reason):
        to_scan(replace(OTHERS, **changes), STAMPER)


def test_a_scan_is_on_the_bus_as_of_one_instant() -> None:
    message = sent(from_scan(SCAN, STAMPER))
    assert message.header == STAMPER.header(STAMP_NS, "laser")
    assert (message.angle_min, message.angle_max, message.angle_increment) == (-0.5, 0.5, 0.25)
    assert message.time_increment == 0
    np.testing.assert_array_equal(message.ranges, SCAN.ranges_m)


@given(
    stamp_ns=stamps_ns,
    ranges_m=st.lists(st.floats(0, 80, width=32) | st.sampled_from([INF, -INF, NAN]), max_size=20),
    angle_min=st.floats(-4, 4, width=32),
    angle_increment=st.floats(0.015625, 0.25, width=32),
    reach_m=st.floats(1, 80, width=32) | st.just(INF),
)
def test_a_scan_comes_back(
    stamp_ns: int, ranges_m: list[float], angle_min: float, angle_increment: float, reach_m: float
) -> None:
    scan = Scan(stamp_ns, np.array(ranges_m, np.float32), angle_min, angle_increment, 0.5, reach_m)
    back = to_scan(sent(from_scan(scan, STAMPER)), STAMPER)
    np.testing.assert_array_equal(back.ranges_m, scan.ranges_m)
    assert (back.stamp_ns, back.beam_dt_ns) == (stamp_ns, None)
    assert (back.angle_min, back.angle_increment) == (angle_min, angle_increment)
    assert (back.range_min_m, back.range_max_m) == (0.5, reach_m)


def test_a_scan_that_is_not_deskewed_is_not_for_the_bus() -> None:
    with pytest.raises(RefusedError, match="not deskewed"):
        from_scan(replace(SCAN, beam_dt_ns=np.zeros(5, np.int64)), STAMPER)


def test_another_drivers_scan_is_stamped_with_its_middle_beam() -> None:
    scan = to_scan(replace(OTHERS, time_increment=0.001), STAMPER)
    assert scan.stamp_ns == STAMP_NS + 1_000_000
    assert scan.beam_dt_ns.tolist() == [-1_000_000, 0, 1_000_000]


def test_between_two_middle_beams_is_the_middle() -> None:
    scan = to_scan(replace(OTHERS, ranges=[1.0] * 4, time_increment=0.5), STAMPER)
    assert scan.stamp_ns == STAMP_NS + 750_000_000
    assert scan.beam_dt_ns.tolist() == [-750_000_000, -250_000_000, 250_000_000, 750_000_000]


def test_a_scan_without_beams_is_of_one_instant() -> None:
    scan = to_scan(replace(OTHERS, ranges=[], time_increment=0.5), STAMPER)
    assert (scan.stamp_ns, len(scan.ranges_m), scan.beam_dt_ns) == (STAMP_NS, 0, None)


def test_a_scan_to_the_right_is_one_too() -> None:
    assert to_scan(replace(OTHERS, angle_increment=-0.25), STAMPER).angles.tolist() == [0.0, -0.25, -0.5]


@pytest.mark.parametrize("angle", [NAN, INF])
def test_angles_that_are_none_are_refused(angle: float) -> None:
    refused("angle_min: expected a finite angle", angle_min=angle)
    refused("angle_increment: expected a finite angle", angle_increment=angle)


def test_a_scan_that_cannot_be_is_refused() -> None:
    refused("angle_increment: expected a finite angle other than 0", angle_increment=0.0)
    refused("expected a turn at most, got 382 degrees", angle_increment=3.3333)
    refused("range_min: expected 0 m or more", range_min=-1.0)
    refused("range_min: expected 0 m or more", range_min=NAN)
    refused("range_max: expected above range_min", range_max=0.125)
    refused("range_max: expected above range_min", range_max=NAN)
    refused("ranges: expected 0 m or more, got -2", ranges=[1.0, -2.0, -INF])
    refused("expected at most 65536 beams", ranges=[1.0] * 65537)
    for time_increment in (-0.001, 4.0, NAN, INF):
        refused("time_increment: expected a sweep of 0 to 10 s", time_increment=time_increment)


def clusters() -> list[Cluster]:
    return [Cluster(np.array([0]), 1.0, -0.5, 0.0), Cluster(np.array([0, 1]), 1.0, -0.5, 1.0)]


def test_the_points_of_clusters_come_back() -> None:
    message = sent(from_clusters(SCAN, clusters(), STAMPER))
    one, two = to_clusters(message)
    expected = np.array([[math.cos(-0.5), math.sin(-0.5)], [2 * math.cos(-0.25), 2 * math.sin(-0.25)]])
    np.testing.assert_allclose(one, expected[:1])
    np.testing.assert_allclose(two, expected)


def test_new_clusters_stand_instead_of_the_old_ones() -> None:
    message = from_clusters(SCAN, clusters(), STAMPER)
    assert [marker.action for marker in message.markers] == [Marker.DELETEALL, Marker.ADD, Marker.ADD]
    assert len({(marker.ns, marker.id) for marker in message.markers[1:]}) == 2
    assert message.markers[1].color != message.markers[2].color
    assert all(marker.header == STAMPER.header(STAMP_NS, "laser") for marker in message.markers)
    assert to_clusters(sent(from_clusters(SCAN, [], STAMPER))) == []


def test_points_that_are_none_are_refused() -> None:
    markers = from_clusters(SCAN, clusters(), STAMPER).markers
    with pytest.raises(WireError, match="clusters: 0: expected finite points"):
        to_clusters(MarkerArray([replace(markers[1], points=[Point(NAN)])]))
    assert to_clusters(MarkerArray([replace(markers[1], ns="somebody's", points=[Point(NAN)])])) == []
