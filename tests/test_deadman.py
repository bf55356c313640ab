# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A deadman switch trusts only what is fed to it, fresh and often enough."""

from __future__ import annotations

import pytest

from edgefusion.errors import RefusedError
from edgefusion.navigation.deadman import Deadman, DeadmanState


def test_a_deadman_is_armed_by_later_fresh_stamps_only() -> None:
    deadman = Deadman("scan", 100, needed=2)
    assert deadman.state is DeadmanState.NEEDS_FEED
    for now, stamp, state in [
        (1000, 950, DeadmanState.NEEDS_FEED),
        (1000, 950, DeadmanState.NEEDS_FEED),
        (1000, 940, DeadmanState.NEEDS_FEED),
        (1050, 950, DeadmanState.NEEDS_FEED),
        (1050, 960, DeadmanState.ARMED),
        (1060, 960, DeadmanState.ARMED),
        (1061, 960, DeadmanState.NEEDS_FEED),
        (1062, 1061, DeadmanState.NEEDS_FEED),
        (1063, 1062, DeadmanState.ARMED),
        (1063, 1064, DeadmanState.NEEDS_FEED),
    ]:
        fault = deadman.step(now, stamp)
        assert deadman.state is state
        assert (fault == "") is (state is DeadmanState.ARMED)


@pytest.mark.parametrize("bad", [(0, 1), (-5, 1), (100, 0)])
def test_a_deadman_that_could_never_or_always_be_armed_is_refused(bad: tuple[int, int]) -> None:
    with pytest.raises(RefusedError, match="scan: expected a positive age limit and count"):
        Deadman("scan", *bad)
