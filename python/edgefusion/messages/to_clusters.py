# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Clusters from MarkerArray."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from edgefusion.messages.cdr import WireError
from edgefusion.messages.from_clusters import NAMESPACE
from edgefusion.messages.visualization_msgs import Marker, MarkerArray


def to_clusters(message: MarkerArray) -> list[npt.NDArray[np.float64]]:
    """The points (x, y) [m] of every cluster, float64 [m, 2] each, in the header's frame.

    Raises WireError for points that are not finite. Other markers are somebody else's.
    """
    return [_points(each) for each in message.markers if _is_cluster(each)]


def _is_cluster(marker: Marker) -> bool:
    return (marker.ns, marker.type, marker.action) == (NAMESPACE, Marker.POINTS, Marker.ADD)


def _points(marker: Marker) -> npt.NDArray[np.float64]:
    points = np.array([(point.x, point.y) for point in marker.points], float).reshape(-1, 2)
    if not np.isfinite(points).all():
        raise WireError(f"clusters: {marker.id}: expected finite points")
    return points
