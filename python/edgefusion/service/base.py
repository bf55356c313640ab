# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The base: its loop in real time, beside a thread for each device. However it ends, the robot is stopped first."""

from __future__ import annotations

import time
from typing import Callable, Sequence, Tuple, TypeVar

from edgefusion.clock import Clock, system_clock
from edgefusion.service.base_inputs import Inputs, Outputs
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.cadence import Cadence, Lateness
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.device_thread import DeviceThread, nothing
from edgefusion.service.ending import Ending
from edgefusion.service.laser_device import LaserDevice, LaserDriver
from edgefusion.service.laser_device import nobody as deaf
from edgefusion.service.requests import Requests
from edgefusion.service.robot_device import RobotDevice, RobotDriver, RobotReport
from edgefusion.types import Goal, Scan, Twist2D
from edgefusion.waiting import Wake

JOIN_S = 2.0

R = TypeVar("R")

Inlet = Callable[[int, "DeviceNews[RobotReport]", "DeviceNews[Scan]"], Inputs]
"""Is asked before every step, in the loop's thread, for what goes into it: the time, and news of robot and laser. It
must not wait for anything."""

Watcher = Callable[[Outputs], None]
"""Is told of every step, in the loop's thread; it must not wait for anything."""

Ear = Callable[[Scan], object]
"""Is told of every scan that may be driven by, as it comes, in the laser's thread; it must not wait for anything."""


def nobody(_: Outputs) -> None:
    """Watches."""


def alone(_: int, robot: DeviceNews[RobotReport], laser: DeviceNews[Scan]) -> Inputs:
    """Nothing comes from other processes."""
    return Inputs(robot, laser)


class Base:
    """run() is for one thread, once; the rest is anybody's, and answered by that thread within a cycle.

    endings: of the robot's and the laser's link. prepare: called first of all by the loop's thread and the devices'.
    """

    def __init__(
        self,
        loop: BaseLoop,
        robot: RobotDriver,
        laser: LaserDriver,
        endings: Tuple[Ending, Ending],
        period_ns: int,
        watcher: Watcher = nobody,
        inlet: Inlet = alone,
        clock: Clock = system_clock,
        pause: Callable[[float], None] = time.sleep,
        prepare: Callable[[], object] = nothing,
        ear: Ear = deaf,
    ) -> None:
        self._loop, self._watcher, self._inlet, self._prepare = loop, watcher, inlet, prepare
        self._wake = Wake()
        self._requests = Requests(self._wake)
        self._cadence = Cadence(period_ns, clock, self._wake.wait)
        self._device = RobotDevice(robot, clock)
        self._robot = DeviceThread(self._device, endings[0], self._wake, clock, pause, prepare)
        self._laser: DeviceThread[Scan] = DeviceThread(
            LaserDevice(laser, self._moves, ear), endings[1], self._wake, clock, pause, prepare
        )
        self._ending = False

    @property
    def lateness(self) -> Lateness:
        """How well the pace is kept."""
        return self._cadence.lateness

    def ask(self, call: Callable[[], R], late_too: bool = False) -> R:
        """What the call returns in the loop's thread, between two steps, or raises. Raises TimeoutError, too, where the
        loop is late; the call is made then only if late_too."""
        return self._requests.ask(call, late_too=late_too)

    def goto(self, goals: Sequence[Goal]) -> None:
        """As BaseLoop.goto. Raises TimeoutError, too."""
        self._requests.ask(lambda: self._loop.goto(goals))

    def cancel(self) -> None:
        """As BaseLoop.cancel. Raises TimeoutError, too."""
        self._requests.ask(self._loop.cancel)

    def stop(self, reason: str) -> None:
        """As BaseLoop.stop. Raises TimeoutError, too, and stops all the same when the loop comes by."""
        self._requests.ask(lambda: self._loop.stop(reason), late_too=True)

    def resume(self) -> None:
        """As BaseLoop.resume. Raises TimeoutError, too."""
        self._requests.ask(self._loop.resume)

    def end(self) -> None:
        """run() returns soon."""
        self._ending = True
        self._wake()

    def run(self) -> None:
        """Until end() or an exception, which it raises; in both cases the robot is told to stop within 50 ms, and what
        takes longer than two seconds to end is left to itself. Raises PortBusyError where another instance has the
        robot or the laser."""
        try:
            self._prepare()
            self._robot.begin()
            self._laser.begin()
            while not self._ending:
                self._cycle()
        finally:
            for thread in (self._robot, self._laser):
                thread.end()
            self._robot.join(JOIN_S)
            self._laser.join(JOIN_S)

    def _moves(self) -> bool:
        report = self._robot.news.newest
        return report is not None and report.state.twist != Twist2D()

    def _cycle(self) -> None:
        now_ns = self._cadence.next()
        for busy in (self._robot.busy, self._laser.busy):
            if busy is not None:
                raise busy
        self._requests.serve()
        outputs = self._loop.step(now_ns, self._inlet(now_ns, self._robot.news, self._laser.news))
        if outputs.enable_motors:
            self._device.enable_motors()
        if outputs.session is not None:
            self._device.drive(outputs.stamp_ns, outputs.command, outputs.session)
        self._watcher(outputs)
