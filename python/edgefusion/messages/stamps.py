# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Stamps of the robot's monotonic clock as the times that ROS shows."""

from __future__ import annotations

from dataclasses import dataclass

from edgefusion.errors import RefusedError
from edgefusion.messages.builtin_interfaces import Time
from edgefusion.messages.cdr import WireError
from edgefusion.messages.std_msgs import Header

_NS_PER_S = 1_000_000_000
_MOST_S = 2**31 - 1


@dataclass(frozen=True)
class Stamper:
    """offset_ns: what UTC was ahead of the stamps' clock when it was looked at, once: a wall clock that is set later
    moves nothing. 0 where stamps are UTC, as in recordings of ROS."""

    offset_ns: int = 0

    def to_time(self, stamp_ns: int) -> Time:
        """Raises RefusedError for a time that ROS cannot express: before 1970 or after 2038."""
        sec, nanosec = divmod(stamp_ns + self.offset_ns, _NS_PER_S)
        if not 0 <= sec <= _MOST_S:
            raise RefusedError(f"stamp: expected a time from 1970 to 2038, got {sec} s after 1970")
        return Time(sec, nanosec)

    def to_ns(self, time: Time) -> int:
        """Raises WireError for a time that is none."""
        if not 0 <= time.nanosec < _NS_PER_S:
            raise WireError(f"stamp: expected nanoseconds below {_NS_PER_S}, got {time.nanosec}")
        if time.sec < 0:
            raise WireError(f"stamp: expected a time from 1970 on, got {time.sec} s")
        return time.sec * _NS_PER_S + time.nanosec - self.offset_ns

    def header(self, stamp_ns: int, frame_id: str) -> Header:
        """What was measured then, in that frame."""
        return Header(self.to_time(stamp_ns), frame_id)
