# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The ring gives what is new enough, and says why where nothing is."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from camera_scenes import scene
from edgefusion.clock import SimClock
from edgefusion.drivers.camera_ring import Arrival, FrameRing, NoFrameError
from edgefusion.types import Frame


def ring_at(now_ns: int, arrivals: list[int], keep_ns: int = 100) -> FrameRing:
    """A ring of pictures that were exposed 7 ns before they arrived."""
    ring = FrameRing(keep_ns, SimClock(now_ns))
    for arrival_ns in arrivals:
        ring.add(Arrival(arrival_ns, Frame(arrival_ns - 7, scene(0))))
    return ring


def test_the_newest_picture_is_given_up_to_its_age_limit_and_no_further() -> None:
    assert ring_at(1050, [1000, 1040]).latest(10).stamp_ns == 1033
    with pytest.raises(NoFrameError, match="age of the newest picture: expected"):
        ring_at(1051, [1000, 1040]).latest(10)


def test_a_picture_from_the_future_is_not_given() -> None:
    with pytest.raises(NoFrameError, match="age"):
        ring_at(1000, [1001]).latest(10**9)


def test_an_empty_or_cleared_ring_says_so() -> None:
    ring = ring_at(10, [10])
    ring.clear()
    for empty in (ring, ring_at(10, [])):
        with pytest.raises(NoFrameError, match="none came"):
            empty.latest(10**9)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=50), st.integers(0, 3000))
def test_it_keeps_exactly_the_pictures_of_its_time_in_order(steps: list[int], after_ns: int) -> None:
    arrivals = [sum(steps[: count + 1]) for count in range(len(steps))]
    kept = [arrival for arrival in arrivals if arrivals[-1] - arrival <= 100]
    found = [frame.stamp_ns + 7 for frame in ring_at(10**6, arrivals).after(after_ns - 7)]
    assert found == [arrival for arrival in kept if arrival > after_ns]
