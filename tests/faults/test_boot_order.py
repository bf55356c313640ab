# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Y5: a base that starts before its devices is ready soon after the last of them, and drives for nobody before."""

from __future__ import annotations

from pathlib import Path

import pytest
from threaded_base import ThreadedBase

from edgefusion.config import SafetyConfig
from edgefusion.navigation.safety import Action
from edgefusion.types import Health, HealthState, Twist2D

S = 1_000_000_000
DEVICES = ("robot", "laser")
ORDERS = [("robot", "laser"), ("laser", "robot")]


@pytest.fixture
def boot(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """A base that starts with some of its devices."""
    monkeypatch.locks = tmp_path
    made: list[ThreadedBase] = []

    def make(seed: int, *plugged: str, **settings: object) -> ThreadedBase:
        made.append(ThreadedBase(monkeypatch, seed, plugged, **settings))
        return made[-1]

    yield make
    for each in made:
        assert not each.clock.errors
        each.clock.finish()


def plugged_in(base: ThreadedBase, name: str) -> None:
    base.lines[name].plugged = True


def switched_on(base: ThreadedBase, name: str) -> None:
    """It was at its port, without power."""
    base.mend(name)
    {"robot": base.robot, "laser": base.scanner}[name].power_cycle(base.clock(), 0.0)


class Dead:
    """What is at a port where a device has no power."""

    def __init__(self, device) -> None:
        self.line = device.line

    def receive(self, data: bytes, baudrate: int | None, now_ns: int) -> None:
        """Nobody hears it."""

    def transmit(self, baudrate: int | None, now_ns: int) -> bytes:
        return b""


@pytest.mark.parametrize(
    ("how", "order"),
    [(plugged_in, order) for order in ORDERS] + [(switched_on, order) for order in (*ORDERS, ("laser",))],
    ids=lambda part: getattr(part, "__name__", "") or " then ".join(part),
)
def test_y5_ready_within_3_s_of_the_last_device_and_never_driving_before(boot, how, order) -> None:
    base = boot(0, *(name for name in DEVICES if how is switched_on or name not in order))
    for name in order if how is switched_on else ():
        base.lines[name].device = Dead(base.lines[name].device)
    for name in order:
        base.run(0.3 + 2 * float(base.rng.random()), base.accepts)
        how(base, name)
    arrived_ns = base.clock()
    base.run(10.0, base.accepts)
    assert 0 < (base.clock() - arrived_ns) / S <= 3.0
    base.run(1.5)
    assert base.world.body.twist.v_mps > 0.1
    drove = [output for output in base.outputs if output.command != Twist2D()]
    assert base.moved_since(0)[0] >= drove[0].stamp_ns > arrived_ns
    assert all({health.state for health in output.healths} == {HealthState.OK} for output in drove)


def test_y5_what_is_required_beside_the_devices_is_waited_for_as_they_are(boot) -> None:
    base = boot(0, *DEVICES, safety=SafetyConfig(required=(*DEVICES, "vision"), optional=("camera", "bus")))
    base.run(3.0, base.accepts)
    assert base.well()
    assert base.outputs[-1].decision.findings[0][:] == (Action.STOP, "vision: no report yet")
    base.others_say = (Health("vision", HealthState.STARTING, "loads its model"),)
    base.run(0.5, base.accepts)
    assert base.moved_since(0) == []
    base.others_say = (Health("vision", HealthState.OK),)
    base.run(0.5, base.accepts)
    base.run(1.0)
    assert base.world.body.twist.v_mps > 0.1
