# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a laser's scans may be driven by: a noisy line, a scanner that repeats itself, a window that sees nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.drivers.lms2xx_judgement import INTACT_SHARE, TELEGRAMS, Judgement, LineQuality

MS = 1_000_000
SIZE = 732
MET = np.full(361, 2.0, np.float32)


class Scanner:
    """Judged scan by scan; a telegram every period."""

    def __init__(self, period_ms: int = 27) -> None:
        self.judgement, self.discarded, self.number = Judgement(), 0, 0
        self._period_ns, self._now_ns = period_ms * MS, 0

    def scan(
        self, ranges_m: np.ndarray = MET, values: bytes | None = None, moving: bool = True, broken: int = 0
    ) -> str:
        """The fault of one more. values: None for new ones; broken: how many telegrams were lost to noise before it."""
        self._now_ns += self._period_ns * (1 + broken)
        self.number += 1
        self.discarded += broken * SIZE
        self.judgement.line.telegram(SIZE, self.discarded)
        said = self.number.to_bytes(4, "big") if values is None else values
        return self.judgement.fault(said, ranges_m, self._now_ns, moving)


def covered(blind: int) -> np.ndarray:
    ranges_m = np.full(100, 2.0, np.float32)
    ranges_m[:blind] = np.nan
    return ranges_m


def test_a_scanner_that_sees_something_else_each_time_is_believed() -> None:
    scanner = Scanner()
    assert [scanner.scan() for _ in range(50)] == [""] * 50


def test_while_the_wheels_turn_the_fifth_equal_scan_is_one_too_many() -> None:
    scanner = Scanner()
    faults = [scanner.scan(values=b"same") for _ in range(6)]
    assert faults[:4] == [""] * 4
    assert faults[4:] == ["it repeats itself: 5 equal scans", "it repeats itself: 6 equal scans"]
    assert scanner.scan(values=b"other") == ""


@pytest.mark.parametrize("period_ms", [27, 191])
def test_while_it_stands_equal_scans_may_come_for_a_second(period_ms: int) -> None:
    scanner = Scanner(period_ms)
    good = 0
    while not scanner.scan(values=b"same", moving=False):
        good += 1
    assert good == -(-1000 // period_ms)


def test_wheels_that_begin_to_turn_count_the_equal_scans_of_before() -> None:
    scanner = Scanner()
    assert [scanner.scan(values=b"same", moving=False) for _ in range(10)] == [""] * 10
    assert scanner.scan(values=b"same", moving=True).startswith("it repeats itself: 11")


@pytest.mark.parametrize(("met", "found"), [(29, False), (30, True)])
def test_in_an_empty_hall_all_scans_may_be_the_same(met: int, found: bool) -> None:
    ranges_m = np.full(361, np.inf, np.float32)
    ranges_m[:met] = 3.0
    scanner = Scanner()
    faults = [scanner.scan(ranges_m, b"same") for _ in range(100)]
    assert any(faults) == found


@pytest.mark.parametrize(("blind", "found"), [(89, False), (90, True), (100, True)])
def test_the_second_scan_of_a_covered_window_is_told(blind: int, found: bool) -> None:
    scanner = Scanner()
    faults = [scanner.scan(covered(blind)) for _ in range(2)]
    assert faults == ["", f"covered or dazzled: {blind} of 100 beams see nothing" if found else ""]
    assert scanner.scan(covered(0)) == ""
    assert scanner.scan(covered(blind)) == ""


def test_a_hand_right_before_the_window_covers_it_and_free_space_does_not() -> None:
    scanner = Scanner()
    near, free = np.full(361, 0.09, np.float32), np.full(361, np.inf, np.float32)
    assert [bool(scanner.scan(near)) for _ in range(2)] == [False, True]
    assert [scanner.scan(free) for _ in range(5)] == [""] * 5


@pytest.mark.parametrize(("lost", "found"), [(4, False), (5, True)])
def test_a_line_may_lose_a_fifth_of_its_telegrams(lost: int, found: bool) -> None:
    scanner = Scanner()
    faults = [scanner.scan() for _ in range(TELEGRAMS)] + [scanner.scan(broken=1) for _ in range(lost)]
    assert [bool(fault) for fault in faults[:-1]] == [False] * (len(faults) - 1)
    assert faults[-1] == ("the line is noisy: 15 of the last 20 telegrams were intact" if found else "")


def test_after_noise_only_a_row_of_intact_telegrams_makes_it_good_again() -> None:
    scanner = Scanner()
    scanner.scan()
    faults = [scanner.scan(broken=1000)] + [scanner.scan() for _ in range(TELEGRAMS)]
    assert sum(map(bool, faults)) == round(INTACT_SHARE * TELEGRAMS) - 1
    assert not any(faults[15:])


def test_what_was_discarded_before_the_start_says_nothing_of_the_line() -> None:
    line = LineQuality(5 * SIZE)
    line.telegram(SIZE, 5 * SIZE)
    assert line.fault == ""


@given(st.lists(st.integers(0, 3), max_size=60))
def test_no_scan_is_believed_while_less_than_half_of_the_last_ten_telegrams_were_intact(broken: list[int]) -> None:
    scanner, intact = Scanner(), []
    for lost in broken:
        intact += [False] * lost + [True]
        fault = scanner.scan(broken=lost)
        if sum(intact[-10:]) < len(intact[-10:]) / 2:
            assert "the line is noisy" in fault


def test_all_that_is_wrong_is_said() -> None:
    scanner = Scanner()
    ranges_m = np.full(361, 0.05, np.float32)
    for _ in range(5):
        fault = scanner.scan(ranges_m, b"same", broken=2)
    assert [part.split(":")[0] for part in fault.split("; ")] == [
        "the line is noisy",
        "it repeats itself",
        "covered or dazzled",
    ]
