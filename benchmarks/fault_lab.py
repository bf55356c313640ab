# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base in real time with the devices of a room, served on ptys: the whole of it, to inject faults into."""

from __future__ import annotations

import math
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, List, Literal

import numpy as np

from edgefusion.clock import system_clock
from edgefusion.config import Config, LaserConfig
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.service.base_devices import open_base
from edgefusion.service.base_inputs import Outputs
from edgefusion.sim.faults import Fault, parse_fault
from edgefusion.sim.live_devices import LiveDevices, LiveSetup
from edgefusion.sim.sip_robot_commands import Told
from edgefusion.sim.world import Wall, World
from edgefusion.types import Goal, Pose2D

CORNERS = ((-2.0, -2.0), (5.0, -2.0), (5.0, 2.0), (-2.0, 2.0))
WALLS = tuple(Wall(start, end, 2.5, 0.1, "plaster") for start, end in zip(CORNERS, CORNERS[1:] + CORNERS[:1]))
ROOM = World("room", 1, "tiles", None, WALLS, (), Pose2D(), Pose2D(1.0, 0.0))
FAR = Goal("far", Pose2D(4.0, 0.0), 0.05, math.pi)

_PUMP_S, _WAIT_S, _POLL_S = 0.002, 30.0, 0.005
_AT_SPEED_MPS = 0.35


class FaultLab:
    """From entering to leaving. seed: of the noise, and of when in their periods things happen."""

    def __init__(self, seed: int, baudrate: Literal[38400, 500000] = 500000) -> None:
        self._rng = np.random.default_rng(seed)
        self._lock, self._over = threading.Lock(), threading.Event()
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        setup = LiveSetup(ROOM, seed, robot_port=0, camera=False, laser_left_at=9600, links=folder)
        self.devices = LiveDevices(setup, system_clock())
        self.config = Config(laser=LaserConfig(baudrate=baudrate))
        ports = self.devices.robot_pty.name, self.devices.laser_pty.name
        self.outputs: List[Outputs] = []
        self.base = open_base(self.config, *ports, watcher=self.outputs.append, lock_folder=folder)
        self._threads = [threading.Thread(target=self._pump), threading.Thread(target=self.base.run)]

    def __enter__(self) -> FaultLab:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.base.end()
        self._threads[1].join()
        self._over.set()
        self._threads[0].join()
        self.devices.close()
        self._folder.cleanup()

    def _pump(self) -> None:
        while not self._over.wait(_PUMP_S):
            with self._lock:
                self.devices.pump(system_clock())

    def driving(self) -> FaultLab:
        """The same, at speed towards a goal, for a moment."""
        self.wait_for(self._takes_the_goal)
        self.wait_for(lambda: self.devices.world.body.twist.v_mps > _AT_SPEED_MPS)
        time.sleep(float(self._rng.uniform(0.0, 0.2)))
        return self

    def _takes_the_goal(self) -> bool:
        try:
            self.base.goto([FAR])
        except RefusedError:
            time.sleep(0.1)
            return False
        return True

    def inject(self, fault: Fault | str) -> int:
        """Returns when."""
        wanted = parse_fault(fault) if isinstance(fault, str) else fault
        with self._lock:
            now_ns = system_clock()
            self.devices.inject(wanted, now_ns)
        return now_ns

    def mend(self) -> int:
        """Returns when."""
        with self._lock:
            self.devices.mend()
            return system_clock()

    def unplug_laser(self) -> int:
        """Returns when."""
        with self._lock:
            self.devices.unplug_laser()
            return system_clock()

    def plug_laser(self) -> int:
        """Returns when."""
        with self._lock:
            self.devices.plug_laser()
            return system_clock()

    def stopped_after_s(self, since_ns: int, within_s: float = 5.0) -> float:
        """From then until the robot is first told to stand [s]; inf where it is not."""
        deadline_s = time.monotonic() + within_s
        while time.monotonic() < deadline_s:
            with self._lock:
                told = [ns for ns, command in list(self.devices.robot.heard) if ns >= since_ns and _stops(command)]
            if told:
                return (told[0] - since_ns) / 1e9
            time.sleep(_POLL_S)
        return math.inf

    def wait_for(self, holds: Callable[[], bool], within_s: float = _WAIT_S) -> float:
        """How long it takes [s]. Raises TimeoutError."""
        begin_s = time.monotonic()
        while not holds():
            if time.monotonic() - begin_s > within_s:
                raise TimeoutError("the lab did not come to it")
            time.sleep(_POLL_S)
        return time.monotonic() - begin_s


def _stops(command: Told) -> bool:
    if command.number in (Command.STOP, Command.E_STOP, Command.CLOSE):
        return True
    return command.number == Command.VEL and command.value == 0
