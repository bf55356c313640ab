# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""An error at any call in a base that drives, over the wires of a simulated robot: the last it hears is to stop."""

from __future__ import annotations

import time
from collections import deque
from typing import Any, Callable, Deque

import pytest

from base_lab import Lab, wait_for
from bus_robot import STOPS
from edgefusion.config import Config, LaserConfig, MissionConfig
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.service.base_devices import open_base
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.types import Goal, Pose2D
from test_base_loop_real import Running, mission_to

FAST = Config(mission=MissionConfig(interest=()), laser=LaserConfig(baudrate=500000))
FAR = Goal("far", Pose2D(3.0, 0.0))


class Trap:
    """Once it is set, the method raises, each time."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, owner: type, name: str) -> None:
        self._call: Callable[..., Any] = getattr(owner, name)
        self.set_ns = 0
        monkeypatch.setattr(owner, name, lambda *arguments: self._run(*arguments))

    def _run(self, *arguments: Any) -> Any:
        if self.set_ns:
            raise ZeroDivisionError("oops")
        return self._call(*arguments)


@pytest.mark.parametrize(
    ("owner", "name"),
    [(Pioneer, "poll"), (Pioneer, "drive"), (Lms2xx, "read"), (BaseLoop, "step")],
    ids=lambda part: getattr(part, "__name__", part),
)
def test_an_error_at_any_call_of_a_base_that_drives_stops_its_robot(
    owner: type, name: str, monkeypatch: pytest.MonkeyPatch, tmp_path
) -> None:
    trap = Trap(monkeypatch, owner, name)
    newest: Deque[Outputs] = deque(maxlen=1)
    with Lab() as lab:
        with Running(open_base(FAST, lab.robot_port, lab.laser_port, newest.append, tmp_path)) as running:
            wait_for(lambda: mission_to(FAR, running.base, newest) and lab.world.body.twist.v_mps > 0.2)
            trap.set_ns = time.monotonic_ns()
            wait_for(lambda: any(ns > trap.set_ns and told in STOPS for ns, told in _pairs(lab)))
            wait_for(lambda: lab.world.body.twist.v_mps == 0)
        wait_for(lambda: not lab.robot.open)
        assert lab.motions()[-1][1:] in STOPS
        assert isinstance(running.error, ZeroDivisionError) == (owner is BaseLoop)


def _pairs(lab: Lab) -> list[tuple[int, tuple[int, int]]]:
    return [(ns, (number, value)) for ns, number, value in lab.motions()]
