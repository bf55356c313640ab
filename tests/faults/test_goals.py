# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Z6: goals that are none; the full volume is `make faults`'."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.faults_goals import KINDS, hostile_goals

from robot_faults import SEEDS


@pytest.mark.parametrize("seed", SEEDS)
def test_z6_nothing_but_wire_error_answers_a_malformed_goal(seed: int) -> None:
    run = hostile_goals(np.random.default_rng(seed), payloads=120 * len(KINDS))
    assert run.others == []
    assert run.understood + run.refused == 120 * len(KINDS)
    # Cut, lengthened and random ones are never goals; of the changed ones some still are.
    assert run.refused >= 4 * 120
    assert run.understood > 0
