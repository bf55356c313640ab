# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""R3: bytes of a robot's line that are noise; the full volume is `make faults`'."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.faults_robot_noise import noisy_drive

from robot_faults import SEEDS


@pytest.mark.parametrize("seed", SEEDS)
def test_r3_at_one_percent_of_noise_intact_packets_are_kept_and_nothing_implausible_passes(seed: int) -> None:
    run = noisy_drive(np.random.default_rng(seed), packets=1500, error=0.01)
    assert run.intact > 700
    assert run.kept >= 0.999 * run.intact
    assert run.implausible == 0
    assert run.off_m <= 0.01


def test_without_noise_nothing_is_left_out() -> None:
    run = noisy_drive(np.random.default_rng(0), packets=2000, error=0.0)
    assert run.kept == run.intact == 2000
    assert run.off_m <= 0.002
