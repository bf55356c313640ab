# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Z4's lines in the table of faults: what makes them bad."""

from __future__ import annotations

import pytest
from benchmarks.faults_bus_commands import COMMANDS, CommandRun, rows_of

WELL = CommandRun(COMMANDS, 0, COMMANDS, 500)


@pytest.mark.parametrize(
    ("run", "broken"),
    [
        (WELL, [False, False]),
        (WELL._replace(refused=COMMANDS - 1), [True, False]),
        (WELL._replace(others=1), [True, False]),
        (WELL._replace(slowed=0), [False, True]),
        (WELL._replace(fastest_mmps=501), [False, True]),
    ],
)
def test_z4_one_run_in_which_a_command_counts_that_must_not_makes_the_line_bad(
    run: CommandRun, broken: list[bool]
) -> None:
    assert [row.broken for row in rows_of([WELL, run])] == broken
