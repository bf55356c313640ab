# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Z4: velocities that are none, or too fast, from an operator who drives `edgefusion base`: what the robot hears."""

from __future__ import annotations

import math
import time
from typing import Callable, List, Mapping, NamedTuple, Sequence

import numpy as np
from benchmarks.fault_row import FaultRow
from benchmarks.faults_base_rig import BaseRig, hall

from edgefusion.bus.client import Robot
from edgefusion.bus.publisher import CommandPublisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL
from edgefusion.config import BaseConfig
from edgefusion.drivers.sip_command import Command
from edgefusion.messages.geometry_msgs import Twist, Vector3

COMMANDS = 60
"""Of each kind, of a run."""
_NONE = (math.nan, math.inf, -math.inf)
_CALM_MMPS, _PAUSE_S, _SAID_S = 100, 0.05, 1.2
_CALM = Twist(Vector3(x=_CALM_MMPS / 1e3))
_REFUSED, _SLOWED = "cmd_vel refused, malformed", "cycles with a command too fast"

Tick = Callable[[], object]


class CommandRun(NamedTuple):
    """refused: how many of those that are none base refused and counted. others: how many velocities the robot was told
    meanwhile that are not the calm ones, nor to stand. slowed: how often base counted what is too fast. fastest_mmps:
    what the robot was told then at most."""

    refused: int
    others: int
    slowed: int
    fastest_mmps: int


def commands_that_are_none(seeds: int, tick: Tick) -> List[FaultRow]:
    """tick: called after each run."""
    runs = []
    for seed in range(seeds):
        runs.append(_run(np.random.default_rng(seed), seed))
        tick()
    return rows_of(runs)


def _run(rng: np.random.Generator, seed: int) -> CommandRun:
    with hall(seed) as rig:
        operator = _Operator(rig)
        begin_ns = time.monotonic_ns()
        refused = operator.counted(_REFUSED, lambda: Twist(Vector3(x=float(rng.choice(_NONE)))))
        then_ns = time.monotonic_ns()
        others = _velocities_mmps(rig, begin_ns) - {0, _CALM_MMPS}
        slowed = operator.counted(_SLOWED, lambda: Twist(Vector3(x=10.0 ** float(rng.uniform(0.0, 300.0)))))
        return CommandRun(refused, len(others), slowed, max(_velocities_mmps(rig, then_ns)))


def rows_of(runs: Sequence[CommandRun]) -> List[FaultRow]:
    """What came of them."""
    refused, others = sum(run.refused for run in runs), sum(run.others for run in runs)
    slowed, fastest = min(run.slowed for run in runs), max(run.fastest_mmps for run in runs)
    sent, most = COMMANDS * len(runs), round(1e3 * BaseConfig().max_speed_mps)
    none = f"{refused} of {sent} refused and counted; the robot was told {others} velocities beside his calm one"
    fast = f"the robot was told {fastest} mm/s at most; base counted {slowed} of a run at least"
    is_well = 0 < fastest <= most and slowed > 0
    return [
        _row("an operator drives, and says NaN and infinite between", "refused, motion unchanged", none,
             refused != sent or others > 0),
        _row("an operator drives, and says up to 1e300 m/s between", f"{most} mm/s", fast, not is_well),
    ]  # fmt: skip


def _row(what: str, aim: str, remark: str, failed: bool) -> FaultRow:
    return FaultRow("Z4", what, aim, math.inf, remark=remark, failed=failed)


def _velocities_mmps(rig: BaseRig, since_ns: int) -> set[int]:
    """What the robot was told since then."""
    heard = [told for ns, told in list(rig.robot.heard) if ns >= since_ns]
    return {told.value for told in heard if told.number == Command.VEL and told.value is not None}


class _Operator:
    """Who drives calmly, beside what he is told to say; base is there and drives so when this is made."""

    def __init__(self, rig: BaseRig) -> None:
        for verb in ("bus", "base"):
            rig.start(verb)
        self._rig, self._client = rig, rig.connect()
        self._publisher = CommandPublisher(self._client.session, "robot", CMD_VEL, Tagger(), 200)
        rig.wait(self._drives)

    def _drives(self) -> bool:
        self._say(_CALM)
        return self._rig.speed_mps > 0.08

    def _say(self, twist: Twist) -> None:
        self._publisher.put(twist)
        time.sleep(_PAUSE_S)

    def counted(self, figure: str, odd: Callable[[], Twist]) -> int:
        """How many more base counts, when it has heard some and calm ones between."""
        before = int(_figures(self._client).get(figure, 0))
        for _ in range(COMMANDS):
            self._say(odd())
            self._say(_CALM)
        end_s = time.monotonic() + _SAID_S
        while time.monotonic() < end_s:
            self._say(_CALM)
        return int(_figures(self._client).get(figure, 0)) - before


def _figures(client: Robot) -> Mapping[str, str]:
    return next((each.figures for each in client.status.healths if each.health.component == "base"), {})
