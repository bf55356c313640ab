# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""LaserScan as scans, ours and those of other drivers."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from edgefusion.messages.cdr import WireError
from edgefusion.messages.sensor_msgs import LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Scan

MOST_BEAMS = 65536
SLOWEST_S = 10.0
"""Of a sweep."""
_ROUNDING = 1e-3
"""What single precision may add to a full turn of many beams [rad]."""


def to_scan(message: LaserScan, stamper: Stamper) -> Scan:
    """Stamped with its middle beam, where ROS stamps the first; beam_dt_ns where the beams are not of one instant.

    Raises WireError for a scan that cannot be.
    """
    _check_angles(message)
    _check_ranges(message)
    ranges_m = np.array(message.ranges, np.float32)
    if ((ranges_m < 0) & np.isfinite(ranges_m)).any():  # -inf: nearer than range_min
        raise WireError(f"ranges: expected 0 m or more, got {ranges_m[np.isfinite(ranges_m)].min():g}")
    middle_ns, beam_dt_ns = _beam_times(message)
    return Scan(
        stamper.to_ns(message.header.stamp) + middle_ns,
        ranges_m,
        message.angle_min,
        message.angle_increment,
        message.range_min,
        message.range_max,
        beam_dt_ns,
    )


def _check_angles(message: LaserScan) -> None:
    beams = len(message.ranges)
    if beams > MOST_BEAMS:
        raise WireError(f"ranges: expected at most {MOST_BEAMS} beams, got {beams}")
    if not math.isfinite(message.angle_min):
        raise WireError(f"angle_min: expected a finite angle, got {message.angle_min}")
    if not (math.isfinite(message.angle_increment) and message.angle_increment):
        raise WireError(f"angle_increment: expected a finite angle other than 0, got {message.angle_increment}")
    sweep = abs(message.angle_increment) * (beams - 1)
    if sweep > 2 * math.pi + _ROUNDING:
        raise WireError(f"angle_increment: expected a turn at most, got {math.degrees(sweep):.0f} degrees")


def _check_ranges(message: LaserScan) -> None:
    if not 0 <= message.range_min < math.inf:
        raise WireError(f"range_min: expected 0 m or more, and finite, got {message.range_min}")
    if not message.range_max > message.range_min:
        raise WireError(f"range_max: expected above range_min, {message.range_min:g} m, got {message.range_max}")


def _beam_times(message: LaserScan) -> tuple[int, npt.NDArray[np.int64] | None]:
    """From the first beam to the middle one, and from there to every beam [ns]; None: all are of one instant."""
    beams, step_s = len(message.ranges), message.time_increment
    if not 0 <= step_s * beams <= SLOWEST_S:
        raise WireError(f"time_increment: expected a sweep of 0 to {SLOWEST_S:g} s, got {step_s * beams} s")
    if not step_s or not beams:
        return 0, None
    dt_ns = np.round((np.arange(beams) - (beams - 1) / 2) * (step_s * 1e9)).astype(np.int64)
    return -int(dt_ns[0]), dt_ns
