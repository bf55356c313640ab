# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The base in virtual time with the product's own threads of devices, which start, poll and break as on a robot."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, Callable, Dict, List, Sequence, Tuple

import msgspec
import virtual_base
from turn_clock import TurnClock
from virtual_base import CYCLE_NS, FAR, S, VirtualBase

from edgefusion.clock import SimClock
from edgefusion.config import SafetyConfig
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.device_thread import Device, DeviceThread
from edgefusion.service.ending import Ending
from edgefusion.types import Health
from virtual_port import VirtualPort

_LOOK_NS = 5_000_000
MOVING = (Command.VEL, Command.RVEL, Command.VEL2, Command.HEAD, Command.DHEAD)
STOPPING = (Command.STOP, Command.E_STOP, Command.CLOSE)


def thread_of(device: Device[Any], clock: SimClock, wake: Callable[[], None], pause: Any) -> DeviceThread[Any]:
    return DeviceThread(device, Ending(), wake, clock, pause)


class ThreadedBase(VirtualBase):
    """plugged: the devices that are there from the beginning. others_say: how other processes are. cycles: what every
    step of the loop was given and what came out. Finish it, so that its threads end."""

    clock: TurnClock

    def __init__(
        self,
        monkeypatch: Any,
        seed: int = 0,
        plugged: Sequence[str] = ("robot", "laser"),
        safety: SafetyConfig = SafetyConfig(),  # noqa: B008
    ) -> None:
        monkeypatch.setattr(virtual_base, "_SharedClock", TurnClock)
        self.others_say: Tuple[Health, ...] = ()
        self.cycles: List[Tuple[Inputs, Outputs]] = []
        super().__init__(monkeypatch, seed)
        self._ports: Dict[str, VirtualPort] = {}
        for name, line in self.lines.items():
            line.plugged = name in plugged
            line.open = partial(self._open, line.open)
        self.loop = BaseLoop(msgspec.structs.replace(self.config, safety=safety), self.age_limit_s)
        self._decide, self.loop.step = self.loop.step, self._told
        self.clock.spawn("robot", self.robot_turn.run)
        self.clock.spawn("laser", self.laser_turn.run)
        self.clock.spawn("loop", self._cycle)

    def _open(self, opened: Callable[[str, int], VirtualPort], name: str, baudrate: int) -> VirtualPort:
        self._ports[name] = opened(name, baudrate)
        return self._ports[name]

    def _turns(self, monkeypatch: Any) -> None:
        super()._turns(monkeypatch)
        devices, pause = (self.robot_turn.device, self.laser_turn.device), self.lines["robot"].pause
        self.robot_turn, self.laser_turn = (
            thread_of(device, self.clock, lambda: self.clock.wake("loop"), pause) for device in devices
        )

    def _cycle(self) -> None:
        while True:
            self.clock.advance(max(0, self._next_ns - self.clock()))
            if self.clock() >= self._next_ns:
                self._next_ns += CYCLE_NS * (1 + (self.clock() - self._next_ns) // CYCLE_NS)
            self._step()

    def _told(self, now_ns: int, inputs: Inputs) -> Outputs:
        inputs = replace(inputs, healths=self.others_say)
        outputs = self._decide(now_ns, inputs)
        self.cycles.append((inputs, outputs))
        return outputs

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> List[Outputs]:
        end_ns, begin = self.clock() + round(seconds * S), len(self.outputs)
        while self.clock() < end_ns and not until():
            self.clock.advance(min(_LOOK_NS, end_ns - self.clock()))
        return self.outputs[begin:]

    def halt(self, seconds: float) -> int:
        """Nothing of it goes on for so long, the caller's thread included, while its devices do. Returns when it goes
        on."""
        end_ns = self.clock() + round(seconds * S)
        self.clock.halt(end_ns - self.clock())
        while self.clock() < end_ns:
            self.clock.advance(min(_LOOK_NS, end_ns - self.clock()))
            for port in self._ports.values():
                port.in_waiting  # noqa: B018  what has come waits in the computer
        return end_ns

    def accepts(self) -> bool:
        """A goal; which it drives to then."""
        try:
            self.loop.goto([FAR])
        except RefusedError:
            return False
        return True

    def moved_since(self, ns: int) -> List[int]:
        """When the robot was told something that moves it."""
        return [then for then, told in self.robot.heard if then >= ns and told.number in MOVING and told.value]

    def motions_since(self, ns: int) -> List[Tuple[int, bool]]:
        """When it was told anything about moving, and whether that was to stand; not to turn is no such word."""
        told = [each for each in self.robot.heard if each[0] >= ns and each[1].number in (*MOVING, *STOPPING)]
        motions = [(then, not each.value or each.number in STOPPING, each.number) for then, each in told]
        return [(then, stands) for then, stands, number in motions if number != Command.RVEL or not stands]
