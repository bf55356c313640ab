# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A room in real time with a simulated Pioneer and a simulated LMS200, each on a pty, for a base beside it."""

from __future__ import annotations

import threading
import time
from typing import Callable

from edgefusion.clock import system_clock
from edgefusion.drivers.sip_command import Command
from edgefusion.sim.live_world import LiveWorld
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer
from edgefusion.sim.world import Wall, World
from edgefusion.types import Pose2D

CORNERS = ((-2.0, -2.0), (4.0, -2.0), (4.0, 2.0), (-2.0, 2.0))
WALLS = tuple(Wall(start, end, 2.5, 0.1, "plaster") for start, end in zip(CORNERS, CORNERS[1:] + CORNERS[:1]))
ROOM = World("room", 1, "tiles", None, WALLS, (), Pose2D(), Pose2D(1.0, 0.0))
PUMP_S = 0.002


class Lab:
    """Its time goes on by itself from entering to leaving. robot, scanner: the firmware of both; robot_port,
    laser_port: where they are."""

    def __init__(self) -> None:
        now_ns = system_clock()
        self.world, self._lock = LiveWorld(ROOM, now_ns), threading.Lock()
        self.robot = SipRobot(self.world.body, now_ns=now_ns)
        self.scanner = LmsScanner(self.world.scan_at, now_ns)
        self._wires = PtyWire(), PtyWire()
        self.robot_port, self.laser_port = (wire.name for wire in self._wires)
        self._served = WireServer([(self.robot, self._wires[:1]), (self.scanner, self._wires[1:])])
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Lab:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()
        for wire in self._wires:
            wire.close()

    def _run(self) -> None:
        while not self._end.wait(PUMP_S):
            with self._lock:
                now_ns = system_clock()
                self.world.step_to(now_ns)
                self._served.pump(now_ns)

    @property
    def pose(self) -> Pose2D:
        with self._lock:
            return self.world.body.pose

    def motions(self) -> list[tuple[int, int, int]]:
        """When, number and value of all that the robot was told about moving, in order."""
        with self._lock:
            heard = list(self.robot.heard)
        kinds = (Command.VEL, Command.RVEL, Command.STOP, Command.E_STOP, Command.CLOSE)
        return [(ns, told.number, told.value) for ns, told in heard if told.number in kinds]

    def drives(self) -> bool:
        """Whether the last velocity that the robot was told is one."""
        return any(number == Command.VEL and value for _, number, value in self.motions()[-2:])


def wait_for(holds: Callable[[], object], within_s: float = 60.0) -> None:
    """Until it does: a machine may be slow."""
    deadline_s = time.monotonic() + within_s
    while not holds():
        assert time.monotonic() < deadline_s, "it did not come to it"
        time.sleep(0.005)
