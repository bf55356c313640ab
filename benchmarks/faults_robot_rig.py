# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated Pioneer on a pty in real time, and the thread of the base that owns and drives it."""

from __future__ import annotations

import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Callable, Iterator

import numpy as np

from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.sip_command import Command
from edgefusion.service.device_thread import DeviceThread
from edgefusion.service.ending import EndableLink
from edgefusion.service.robot_device import RobotDevice, RobotReport
from edgefusion.sim.floor_body import FloorBody
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.wire_device import WireDevice
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.types import HealthState, Twist2D

Rng = np.random.Generator
AHEAD = Twist2D(0.3)
_AT_SPEED_MPS = 0.29
_PUMP_S, _DRIVE_NS, _PATIENCE_S = 0.001, 50_000_000, 20.0
_ZEROS = {(Command.STOP, None), (Command.E_STOP, None), (Command.VEL, 0)}


class Rig:
    """Driven ahead from entering to leaving, or as long as drives says. device: what is at the port; reads: whether it
    takes what is written. said_ns: when it said something last; failed_ns: when the base was told that it failed."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / "robot"
        self.body = FloorBody()
        self.body.echoes = {number: 2.0 + number / 10 for number in range(16)}
        self.robot = SipRobot(self.body, now_ns=time.monotonic_ns())
        self.device: WireDevice = self.robot
        self.reads = self.drives = True
        self.failed_ns = self.said_ns = 0
        self._wire: PtyWire | None = PtyWire(self._path)
        self.link = EndableLink(str(self._path), 9600, "the first", lock_folder=folder)
        self.driver = Pioneer(self.link, PioneerConfig(), BaseConfig())
        self._owned = RobotDevice(self.driver)
        self.thread: DeviceThread[RobotReport] = DeviceThread(self._owned, self.link.ending, self._woken)
        self._end, self._lock = threading.Event(), threading.Lock()
        self._world = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Rig:
        self._world.start()
        self.thread.begin()
        self.wait(self._is_at_speed)
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.end()
        self.thread.join(2.0)
        self._end.set()
        self._world.join()
        self.unplug()

    @property
    def is_lost(self) -> bool:
        """There is no newest report."""
        return self.thread.news.newest is None

    @property
    def port(self) -> str:
        return str(self._path)

    def wait(self, done: Callable[[], bool]) -> None:
        """Until something is so. Raises RuntimeError where it does not come to it."""
        end_s = time.monotonic() + _PATIENCE_S
        while not done():
            if time.monotonic() > end_s:
                raise RuntimeError(f"it did not come to it: {self.thread.news.health}")
            time.sleep(0.0005)

    def unplug(self) -> None:
        """The cable, from the host."""
        with self._lock:
            if self._wire is not None:
                self._wire.close()
                self._wire = None

    def plug(self) -> None:
        """It in again."""
        with self._lock:
            self._wire = PtyWire(self._path)

    def lost_after_s(self, injected_ns: int) -> float:
        """Until the base was told."""
        self.wait(lambda: self.is_lost and self.failed_ns > injected_ns)
        return (self.failed_ns - injected_ns) / 1e9

    def stopped_after_s(self, injected_ns: int) -> float:
        """T0: until the robot heard the first zero."""
        self.wait(lambda: self._first_zero_ns(injected_ns) > 0)
        return (self._first_zero_ns(injected_ns) - injected_ns) / 1e9

    def moved_since(self, ns: int) -> bool:
        """Whether it was told anything that moves it."""
        kinds = (Command.VEL, Command.RVEL)
        return any(then > ns and told.number in kinds and told.value for then, told in list(self.robot.heard))

    def _is_at_speed(self) -> bool:
        report = self.thread.news.newest
        if report is not None and not report.state.motors_enabled:
            self._owned.enable_motors()  # a loaded machine has lost it, and nobody else switches them on again
        return self.body.twist.v_mps > _AT_SPEED_MPS

    def _first_zero_ns(self, since_ns: int) -> int:
        heard = list(self.robot.heard)
        return next((ns for ns, told in heard if ns >= since_ns and (told.number, told.argument) in _ZEROS), 0)

    def _woken(self) -> None:
        if self.thread.news.health.state is HealthState.FAILED:
            self.failed_ns = time.monotonic_ns()

    def _run(self) -> None:
        last_ns = drive_ns = time.monotonic_ns()
        while not self._end.is_set():
            now_ns = time.monotonic_ns()
            self.body.base.step(now_ns - last_ns)
            last_ns = now_ns
            with self._lock:
                if self._wire is not None:
                    self._carry(self._wire, now_ns)
            report = self.thread.news.newest
            if self.drives and report is not None and now_ns >= drive_ns:
                self._owned.drive(now_ns, AHEAD, report.session)
                drive_ns = now_ns + _DRIVE_NS
            time.sleep(_PUMP_S)

    def _carry(self, wire: PtyWire, now_ns: int) -> None:
        data = wire.read() if self.reads else b""
        if data:
            self.device.receive(data, wire.baudrate, now_ns)
        said = self.device.transmit(wire.baudrate, now_ns)
        if said:
            wire.write(said)
            self.said_ns = now_ns


@contextmanager
def driven(rng: Rng) -> Iterator[Rig]:
    """At its speed, for a random while."""
    with tempfile.TemporaryDirectory() as folder, Rig(Path(folder)) as rig:
        time.sleep(0.2 * rng.random())
        yield rig


def stays(moved: int) -> str:
    """In words."""
    return f"moved {moved} times" if moved else "stays"
