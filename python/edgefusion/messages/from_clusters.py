# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Clusters as MarkerArray, as RViz and others draw it."""

from __future__ import annotations

import colorsys
from typing import Sequence

import numpy as np

from edgefusion.messages.frames import LASER
from edgefusion.messages.geometry_msgs import Point, Vector3
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.std_msgs import ColorRGBA, Header
from edgefusion.messages.visualization_msgs import Marker, MarkerArray
from edgefusion.types import Cluster, Scan

NAMESPACE = "clusters"
_POINT_M = 0.05
_GOLDEN = 0.618034
"""Hues so far apart on the circle stay distinct, however many there are."""


def from_clusters(scan: Scan, clusters: Sequence[Cluster], stamper: Stamper, frame_id: str = LASER) -> MarkerArray:
    """The points of every cluster of the scan in a colour of their own, instead of those that were drawn before."""
    header = stamper.header(scan.stamp_ns, frame_id)
    old = Marker(header, NAMESPACE, action=Marker.DELETEALL)
    return MarkerArray([old, *(_marker(header, number, scan, each) for number, each in enumerate(clusters))])


def _marker(header: Header, number: int, scan: Scan, cluster: Cluster) -> Marker:
    ranges_m, angles = scan.ranges_m[cluster.indices].astype(float), scan.angles[cluster.indices]
    x_m, y_m = ranges_m * np.cos(angles), ranges_m * np.sin(angles)
    return Marker(
        header,
        NAMESPACE,
        number,
        Marker.POINTS,
        Marker.ADD,
        scale=Vector3(_POINT_M, _POINT_M, 0.0),
        color=ColorRGBA(*colorsys.hsv_to_rgb(number * _GOLDEN % 1, 0.9, 1.0), 1.0),
        points=[Point(x, y) for x, y in zip(x_m.tolist(), y_m.tolist())],
    )
