# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A hall in real time with a simulated Pioneer and LMS200 on ptys, and `edgefusion bus` and `base` as processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Sequence, Tuple

from benchmarks.faults_bus_rig import free_port

from edgefusion.bus.client import Robot, connect
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.service.real_time import run_in_real_time
from edgefusion.sim.live_world import LiveWorld
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.wire_device import WireDevice
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer
from edgefusion.sim.world import Wall, World
from edgefusion.types import Pose2D

PATIENCE_S, AT_SPEED_MPS = 30.0, 0.35
DEVICES = ("robot", "laser")
ENDS = {Command.STOP, Command.E_STOP, Command.CLOSE}
_MOTIONS = {Command.VEL, Command.VEL2, *ENDS}
_CORNERS = ((-2.0, -2.0), (40.0, -2.0), (40.0, 2.0), (-2.0, 2.0))
_WALLS = tuple(Wall(a, b, 2.5, 0.1, "plaster") for a, b in zip(_CORNERS, _CORNERS[1:] + _CORNERS[:1]))
_HALL = World("hall", 1, "tiles", None, _WALLS, (), Pose2D(), Pose2D(1.0, 0.0))
_PUMP_S = 0.001
_CONFIG = """
[robot]
port = "{folder}/robot"
[laser]
port = "{folder}/laser"
baudrate = 500000
[mission]
interest = []
[bus]
listen = ["{endpoint}"]
[service]
processes = ["bus", "base"]
"""


class Dead:
    """What is at a port whose device has no power."""

    def __init__(self, device: WireDevice) -> None:
        self.line = device.line

    def receive(self, data: bytes, baudrate: int | None, now_ns: int) -> None:
        """Nobody hears it."""

    def transmit(self, baudrate: int | None, now_ns: int) -> bytes:
        return b""


class BaseRig:
    """Devices from entering to leaving, at folder/robot and folder/laser; processes from when they are started."""

    def __init__(self, folder: Path, seed: int = 0) -> None:
        self.folder, self.endpoint = folder, f"tcp/127.0.0.1:{free_port()}"
        now_ns = time.monotonic_ns()
        self.world = LiveWorld(_HALL, now_ns, seed)
        self.robot = SipRobot(self.world.body, now_ns=now_ns)
        self.laser = LmsScanner(self.world.scan_at, now_ns)
        self._devices: Dict[str, Any] = {"robot": self.robot, "laser": self.laser}
        self._wires: Dict[str, PtyWire] = {}
        self._server = WireServer([(self._devices[name], ()) for name in DEVICES])
        self._lock, self._over = threading.Lock(), threading.Event()
        self._pump = threading.Thread(target=self._run, daemon=True)
        self.processes: Dict[str, subprocess.Popen[bytes]] = {}
        self._clients: List[Robot] = []
        (folder / "robot.toml").write_text(_CONFIG.format(folder=folder, endpoint=self.endpoint), encoding="utf-8")

    def __enter__(self) -> BaseRig:
        self._pump.start()
        return self

    def __exit__(self, *_: object) -> None:
        for client in self._clients:
            client.close()
        for process in self.processes.values():
            process.send_signal(signal.SIGCONT)
            process.kill()
            process.wait()
        self._over.set()
        self._pump.join()
        for wire in self._wires.values():
            wire.close()

    def _run(self) -> None:
        run_in_real_time()  # devices wait for no computer
        while not self._over.wait(_PUMP_S):
            with self._lock:
                now_ns = time.monotonic_ns()
                self.world.step_to(now_ns)
                self._server.pump(now_ns)

    def plug(self, *names: str) -> BaseRig:
        """Their ports are there."""
        with self._lock:
            for name in names:
                self._wires[name] = PtyWire(self.folder / name)
                self._server.rewire(DEVICES.index(name), self._wires[name])
        return self

    def switch_off(self, name: str) -> None:
        """Its port stays."""
        with self._lock:
            self._server.replace(DEVICES.index(name), Dead(self._devices[name]))

    def switch_on(self, name: str) -> None:
        """As new."""
        with self._lock:
            self._server.replace(DEVICES.index(name), self._devices[name])
            self._devices[name].power_cycle(time.monotonic_ns(), 0.0)

    def start(
        self, verb: str, environment: Dict[str, str] | None = None, prepare: Any = None
    ) -> subprocess.Popen[bytes]:
        """prepare: called in the child before it is that program."""
        argv = [sys.executable, "-m", "edgefusion.cli", verb, "--config", str(self.folder / "robot.toml")]
        variables = {**os.environ, "TMPDIR": str(self.folder), **(environment or {})}
        process = subprocess.Popen(argv, env=variables, stderr=subprocess.DEVNULL, preexec_fn=prepare)
        self.processes[verb] = process
        return process

    def connect(self) -> Robot:
        def connected() -> bool:
            with suppress(ConnectionError):
                self._clients.append(connect(self.endpoint))
                return True
            return False

        self.wait(connected)
        return self._clients[-1]

    def drive(self, client: Robot, x_m: float = 38.0) -> None:
        """Until it does, at speed."""

        def goes() -> bool:
            mission = client.status.mission
            if mission is None or mission.state in ("idle", "stopped"):
                with suppress(RefusedError, ConnectionError):
                    client.goto(x_m, 0.0)
            return self.speed_mps > AT_SPEED_MPS

        self.wait(goes)

    @property
    def speed_mps(self) -> float:
        return self.world.body.twist.v_mps

    def motions(self, since_ns: int = 0) -> List[Tuple[int, bool]]:
        """When the robot was told anything about driving, and whether that was to stand."""
        told = [each for each in list(self.robot.heard) if each[0] >= since_ns and each[1].number in _MOTIONS]
        return [(ns, each.number in ENDS or not each.value) for ns, each in told]

    def first_motion(self, since_ns: int) -> Tuple[int, bool]:
        """As motions, once there is one."""
        self.wait(lambda: self.motions(since_ns))
        return self.motions(since_ns)[0]

    def stopped_after_s(self, since_ns: int) -> float:
        """T0."""
        self.wait(lambda: any(stands for _, stands in self.motions(since_ns)))
        return (next(ns for ns, stands in self.motions(since_ns) if stands) - since_ns) / 1e9

    def wait(self, done: Callable[[], object], within_s: float = PATIENCE_S) -> None:
        """Raises RuntimeError where it does not come to it."""
        end_s = time.monotonic() + within_s
        while not done():
            if time.monotonic() > end_s:
                raise RuntimeError("the rig did not come to it")
            time.sleep(0.002)


@contextmanager
def hall(seed: int, plugged: Sequence[str] = DEVICES) -> Iterator[BaseRig]:
    """One with these devices at their ports."""
    with tempfile.TemporaryDirectory() as folder, BaseRig(Path(folder), seed) as rig:
        yield rig.plug(*plugged)


@contextmanager
def driving(
    seed: int, environment: Dict[str, str] | None = None, prepare: Any = None
) -> Iterator[Tuple[BaseRig, Robot]]:
    """One whose robot goes ahead at speed, and a client."""
    with hall(seed) as rig:
        for verb in ("bus", "base"):
            rig.start(verb, environment, prepare)
        client = rig.connect()
        rig.drive(client)
        yield rig, client
