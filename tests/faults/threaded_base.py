# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The base in virtual time with the product's own threads of devices, taken turn by turn: they start, poll and break as
they do on a robot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Sequence, Tuple

from virtual_base import FAR, VirtualBase

from edgefusion.clock import SimClock
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.device_thread import Device, DeviceThread
from edgefusion.service.ending import Ending
from edgefusion.types import Health


class _Broken:
    """A device that goes on raising what it raised once: the thread is asked twice here."""

    def __init__(self, device: Device[Any]) -> None:
        self._device, self._error = device, None

    @property
    def health(self) -> Health:
        return self._device.health

    def start(self) -> None:
        self._try(self._device.start)

    def poll(self) -> Sequence[Any]:
        return self._try(self._device.poll)

    def close(self) -> None:
        self._device.close()

    def _try(self, call: Any) -> Any:
        if self._error is not None:
            raise self._error
        try:
            return call()
        except ArithmeticError as error:  # what tests have them raise, and no driver does
            self._error = error
            raise


class ThreadTurn:
    """One turn of a device's thread at a time; after what ends that thread, nothing but time passes."""

    def __init__(self, device: Device[Any], clock: SimClock, pause: Any) -> None:
        self._clock, self.ended = clock, False
        self.thread: DeviceThread[Any] = DeviceThread(_Broken(device), Ending(), lambda: None, clock, pause)

    @property
    def news(self) -> DeviceNews[Any]:
        return self.thread.news

    def take(self) -> None:
        if self.ended:
            self._clock.advance(5_000_000)
            return
        try:
            self.thread.turn()
        except ArithmeticError:
            self.ended = True
            self.thread.run()

    def end(self) -> None:
        """As when the base ends."""
        self.thread.end()
        self.thread.run()
        self.ended = True


class _Told:
    """A loop that hears how other processes are, for one step."""

    def __init__(self, loop: BaseLoop, healths: Tuple[Health, ...]) -> None:
        self._loop, self._healths = loop, healths

    def step(self, now_ns: int, inputs: Inputs) -> Outputs:
        return self._loop.step(now_ns, replace(inputs, healths=self._healths))


class ThreadedBase(VirtualBase):
    """plugged: the devices that are there from the beginning. others_say: how other processes are."""

    def __init__(self, monkeypatch: Any, seed: int = 0, plugged: Sequence[str] = ("robot", "laser")) -> None:
        self.others_say: Tuple[Health, ...] = ()
        super().__init__(monkeypatch, seed)
        for name, line in self.lines.items():
            line.plugged = name in plugged

    def _step(self) -> None:
        step, self.loop = self.loop, _Told(self.loop, self.others_say)
        super()._step()
        self.loop = step

    def _turns(self, monkeypatch: Any) -> None:
        super()._turns(monkeypatch)
        pause = self.lines["robot"].pause
        self.robot_turn = ThreadTurn(self.robot_turn.device, self.clock, pause)
        self.laser_turn = ThreadTurn(self.laser_turn.device, self.clock, pause)

    def accepts(self) -> bool:
        """A goal; which it drives to then."""
        try:
            self.loop.goto([FAR])
        except RefusedError:
            return False
        return True

    def moved_since(self, ns: int) -> list[tuple[int, int, int]]:
        """When, and what the robot was told that moves it."""
        kinds = (Command.VEL, Command.RVEL, Command.VEL2, Command.HEAD, Command.DHEAD)
        told = [(then, each.number, each.value) for then, each in self.robot.heard]
        return [each for each in told if each[0] >= ns and each[1] in kinds and each[2]]
