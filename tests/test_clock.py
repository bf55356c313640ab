# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The clocks: the system's, and one that goes only when it is told to."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.clock import Clock, SimClock, system_clock
from edgefusion.errors import RefusedError


def test_simulated_time_stands_until_it_is_advanced() -> None:
    clock: Clock = SimClock(5)
    assert [clock(), clock()] == [5, 5]


@given(st.integers(0, 10**15), st.lists(st.integers(0, 10**12)))
def test_simulated_time_is_the_sum_of_all_steps_to_the_nanosecond(start_ns: int, steps_ns: list[int]) -> None:
    clock = SimClock(start_ns)
    for done, step_ns in enumerate(steps_ns, 1):
        assert clock.advance(step_ns) == clock() == start_ns + sum(steps_ns[:done])


def test_simulated_time_never_steps_back() -> None:
    clock = SimClock(7)
    with pytest.raises(RefusedError, match=r"^ns: expected at least 0, got -1: a clock never steps back$"):
        clock.advance(-1)
    assert clock() == 7


def test_the_systems_clock_never_steps_back() -> None:
    stamps_ns = [system_clock() for _ in range(1000)]
    assert stamps_ns == sorted(stamps_ns)
