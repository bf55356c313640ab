# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""L4: bytes of a laser's line that are noise; the full volume is `make faults`'."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.faults_laser_noise import noisy_stream


@pytest.mark.parametrize("error", [0.0001, 0.001, 0.01])
def test_l4_intact_telegrams_are_kept_and_none_that_is_false_is_driven_by(error: float) -> None:
    run = noisy_stream(np.random.default_rng(3), 1000, error)
    assert run.kept == run.intact
    assert run.driven_by == 0
    if error == 0.0001:
        assert run.used >= 0.98 * run.intact > 900
    else:
        assert run.used <= 50


def test_without_noise_every_telegram_is_driven_by() -> None:
    run = noisy_stream(np.random.default_rng(0), 200, 0.0)
    assert run.used == run.kept == run.intact == 200 and run.false == 0
