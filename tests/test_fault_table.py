# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The table of faults: what is met, missed and broken, and that every letter has its parts."""

from __future__ import annotations

import math
from importlib.util import find_spec

import pytest
from benchmarks.fault_row import FaultRow
from benchmarks.faults import PARTS, cells, main


@pytest.mark.parametrize(
    ("worst_s", "failed", "word"),
    [
        (0.1, False, "met"),
        (0.11, False, "missed"),
        (0.3, False, "missed"),
        (0.31, False, "broken"),
        (0.1, True, "broken"),
    ],
)
def test_a_figure_is_broken_beyond_three_times_its_aim_or_where_it_came_to_something_else(
    worst_s: float, failed: bool, word: str
) -> None:
    row = FaultRow("S3", "halted, until told to stop", "100 ms", 0.1, [0.01, worst_s, 0.02], "", failed)
    assert cells(row)[3:7] == ["20 ms", f"{1e3 * worst_s:.0f} ms", "3", word]


def test_a_figure_that_is_no_time_says_what_came_of_it() -> None:
    row = FaultRow("I3", "answers that are none", "no exception", math.inf, [], "0 exceptions")
    assert cells(row)[3:] == ["", "", "", "met", "0 exceptions"]


def test_every_letter_names_parts_that_are_there() -> None:
    for part in (part for parts in PARTS.values() for part in parts):
        assert find_spec(f"benchmarks.faults_{part}") is not None, part


def test_a_letter_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--only", "S,Q"])
    assert f"expected some of {','.join(PARTS)}, got S,Q" in capsys.readouterr().err
