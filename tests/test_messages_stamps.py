# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Stamps of a monotonic clock and the times of ROS."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.messages.builtin_interfaces import Time
from edgefusion.messages.cdr import WireError
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.std_msgs import Header


def test_a_stamp_is_as_much_later_as_utc_was_ahead() -> None:
    assert Stamper(5_000_000_000).to_time(1_250_000_000) == Time(6, 250_000_000)
    assert Stamper(5_000_000_000).header(0, "laser") == Header(Time(5, 0), "laser")


def test_without_an_offset_a_stamp_is_utc() -> None:
    assert Stamper().to_ns(Time(1_700_000_000, 1)) == 1_700_000_000_000_000_001


@given(offset_ns=st.integers(-(10**18), 10**18), time_ns=st.integers(0, 2**31 * 10**9 - 1))
def test_a_stamp_comes_back_to_the_nanosecond(offset_ns: int, time_ns: int) -> None:
    stamper = Stamper(offset_ns)
    assert stamper.to_ns(stamper.to_time(time_ns - offset_ns)) == time_ns - offset_ns


@pytest.mark.parametrize("stamp_ns", [-1, 2**31 * 10**9])
def test_what_ros_cannot_express_is_refused(stamp_ns: int) -> None:
    with pytest.raises(RefusedError, match="expected a time from 1970 to 2038"):
        Stamper().to_time(stamp_ns)


def test_a_time_that_is_none_is_refused() -> None:
    with pytest.raises(WireError, match="expected nanoseconds below 1000000000, got 1000000000"):
        Stamper().to_ns(Time(1, 10**9))
    with pytest.raises(WireError, match="expected a time from 1970 on, got -1 s"):
        Stamper().to_ns(Time(-1, 0))
