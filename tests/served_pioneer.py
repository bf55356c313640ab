# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulated Pioneer on a pty, in real time, in a thread of the test's own."""

from __future__ import annotations

import threading
import time
from pathlib import Path

from edgefusion.sim.floor_body import FloorBody
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import SH, Character
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer


class ServedPioneer:
    """port: where it is, from entering to leaving. told: what it heard so far."""

    def __init__(self, port: Path, character: Character = SH) -> None:
        self.port = str(port)
        self.body = FloorBody()
        self.robot = SipRobot(self.body, character, time.monotonic_ns())
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> ServedPioneer:
        self._wire = PtyWire(Path(self.port))
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()
        self._wire.close()

    def told(self) -> list[tuple[int, int | None]]:
        return [(told.number, told.argument) for _, told in self.robot.heard]

    def _run(self) -> None:
        server, last_ns = WireServer([(self.robot, (self._wire,))]), time.monotonic_ns()
        while not self._end.is_set():
            now_ns = time.monotonic_ns()
            self.body.base.step(now_ns - last_ns)
            server.pump(now_ns)
            last_ns = now_ns
            time.sleep(0.002)
