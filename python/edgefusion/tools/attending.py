# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Commands to a robot that drives only while an operator is there."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import Iterator

from edgefusion.bus.client import Robot
from edgefusion.bus.heartbeat import PERIOD_S


@contextmanager
def attending(robot: Robot) -> Iterator[None]:
    """Within this an operator is there, also to the robot: what it is asked for may depend on that."""
    with robot.attend():
        time.sleep(2 * PERIOD_S)  # the robot has heard of it by then
        yield
