# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Scans as LaserScan."""

from __future__ import annotations

from edgefusion.errors import RefusedError
from edgefusion.messages.frames import LASER
from edgefusion.messages.sensor_msgs import LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Scan


def from_scan(scan: Scan, stamper: Stamper, frame_id: str = LASER) -> LaserScan:
    """A deskewed scan: all beams are of its stamp. Raises RefusedError for one that is not."""
    if scan.beam_dt_ns is not None:
        raise RefusedError("scan: expected one whose beams are all of its stamp, got one that is not deskewed")
    ranges_m = scan.ranges_m.tolist()
    return LaserScan(
        stamper.header(scan.stamp_ns, frame_id),
        scan.angle_min,
        scan.angle_min + scan.angle_increment * max(len(ranges_m) - 1, 0),
        scan.angle_increment,
        range_min=scan.range_min_m,
        range_max=scan.range_max_m,
        ranges=ranges_m,
    )
