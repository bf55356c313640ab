# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A program that drives to one goal after the other for days does not run out of handles."""

from __future__ import annotations

import gc
from contextlib import ExitStack
from pathlib import Path
from typing import Iterator

import pytest

from bus_lab import Lab
from edgefusion.bus.client import Robot
from edgefusion.bus.session import UnreachableError
from edgefusion.bus.topics import MISSION, key_of


@pytest.fixture
def no_collector() -> Iterator[None]:
    """It comes when many objects were made: in a program that mostly waits, after hours."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def handles() -> int:
    return sum(1 for _ in Path("/proc/self/fd").iterdir())


def test_what_was_listened_to_until_its_end_leaves_no_handles(no_collector: None) -> None:
    with ExitStack() as stack:
        lab = Lab(stack)
        lab.router()
        robot = Robot(lab.client(), "robot")

        def follow() -> None:
            with pytest.raises(UnreachableError, match=key_of("robot", MISSION.name)):
                next(robot.missions(timeout_s=0.01))

        follow()
        before = handles()
        for _ in range(10):
            follow()
        assert handles() == before
